"""Which habit made a search go as it went: the same episode again, with one sentence taken out or changed."""
