"""Making lives: places for each thing, days of use, requests."""
