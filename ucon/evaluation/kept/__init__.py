"""Stored runs: records, checksums, reading, recomputing and replaying them."""
