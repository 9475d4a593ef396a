"""``UcONSearch-v0``: an action chooses the view to go to."""
