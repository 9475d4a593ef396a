"""What ``eval.py`` and ``train.py`` do: choosing and checking a run, playing it, and reporting errors in one line."""
