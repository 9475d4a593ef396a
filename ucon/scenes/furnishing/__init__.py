"""Furnishing of rooms: groups of furniture, where they may stand, and what is put on them."""
