"""The HTML around every page: head, menu, scripts. What a page shows is made by its script."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Final

from starlette.responses import HTMLResponse, PlainTextResponse, Response

import ucon.pages

_DATA: Final = Path(ucon.pages.__file__).parent / "data"
_TYPES: Final[Mapping[str, str]] = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}

#: Pages by name: title, and the scripts in addition to those of all pages.
PAGES: Final[Mapping[str, tuple[str, Sequence[str]]]] = {
    "runs": ("Runs", ("charts.js", "lives.js", "lives_live.js")),
    "homes": ("Homes", ("plan.js",)),
    "habits": ("Habits", ("plan.js",)),
    "play": ("Play", ("plan.js",)),
    "study": ("Study", ("charts.js",)),
}
_SHARED: Final = ("page.js", "served.js")


def page(name: str) -> Response:
    """A page.

    Args:
        name: one of :data:`PAGES`, or ``start``.
    """
    title = PAGES[name][0] if name in PAGES else "UcON"
    links = "".join(
        f'<a href="{other}"{" aria-current=page" if other == name else ""}>{escape(PAGES[other][0])}</a>'
        for other in PAGES
    )
    scripts = (*_SHARED, *(PAGES[name][1] if name in PAGES else ()), f"{name}_page.js")
    tags = "".join(f'<script src="assets/{script}" defer></script>' for script in scripts)
    return HTMLResponse(
        f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}{"" if name == "start" else " · UcON"}</title><link rel="icon" href="assets/icon.svg">
<link rel="stylesheet" href="assets/theme.css"><link rel="stylesheet" href="assets/served.css">{tags}</head>
<body><a class="skip" href="#main">Skip to content</a>
<header class="top"><a class="brand" href="./">UcON</a><nav aria-label="Pages">{links}</nav></header>
<main id="main" tabindex="-1"><noscript>These pages need JavaScript.</noscript></main></body></html>
"""
    )


@cache
def _assets() -> Mapping[str, Path]:
    return {path.name: path for path in _DATA.iterdir() if path.suffix in _TYPES}


def asset(name: str) -> Response:
    """A script, style or picture that pages load.

    Args:
        name: of the file.
    """
    path = _assets().get(name)
    if path is None:
        return PlainTextResponse("no such file\n", 404)
    return Response(path.read_bytes(), media_type=_TYPES[path.suffix])
