"""``eval.py`` and ``train.py`` behind their first line."""
