"""Which habit caused a search's outcome: the same episode again, with one sentence removed or changed."""
