"""Where to look next: views, candidates, and walking up to what was found."""
