"""Places where a target may be: on, in, under and beside what was seen."""
