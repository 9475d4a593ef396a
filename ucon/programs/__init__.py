"""What ``eval.py`` and ``train.py`` do: choosing and checking a run, playing it, and errors in one line."""
