"""``UcONSearch-v0``, in which an action chooses the view to go to."""
