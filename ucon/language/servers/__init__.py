"""Language models behind an HTTP server, and their answers kept on disk."""
