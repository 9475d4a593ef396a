"""Pages for people: reports of runs, and what ``python -m ucon serve`` shows. Styles and scripts are in ``data/``."""
