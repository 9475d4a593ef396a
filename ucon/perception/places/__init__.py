"""Places where a target may be: on, in, under and next to what was seen."""
