"""Programs that fit and measure the shipped weights and tables: ``python -m ucon data``."""
