"""A user's own homes: a file describes rooms, furniture, habits and requests, and is turned into episodes."""
