"""Programs that fit and measure what is shipped: ``python -m ucon data``."""
