"""Habit datasets in figures, and surveys among people about them."""
