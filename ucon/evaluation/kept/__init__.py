"""Runs as they are kept: records, checksums, reading, recomputing and replaying them."""
