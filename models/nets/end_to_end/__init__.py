"""Parts of the end-to-end habit policy."""
