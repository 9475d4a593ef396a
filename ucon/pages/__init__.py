"""Pages for people: reports of runs, and what ``python -m ucon serve`` shows. HTML, CSS and JavaScript are in ``data/``."""
