"""Language models behind an HTTP server, and a cache of their answers on disk."""
