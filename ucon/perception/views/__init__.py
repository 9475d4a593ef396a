"""Where to look next: the value of views, short lists of candidates, and walking up to what was found."""
