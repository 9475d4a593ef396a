"""``UcONSearch-v0``: choose which view to go to."""
