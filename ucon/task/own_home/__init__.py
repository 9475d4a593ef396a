"""Homes of one's own: a file describes rooms, furniture, habits and requests, and is turned into episodes."""
