"""Furnishing rooms: groups, where they may stand, and what stands on them."""
