"""Pages for people: reports of runs, and what ``python -m ucon serve`` shows. CSS and JavaScript are in ``data/``."""
