"""One HTML file that needs nothing else: it contains style, scripts and compressed data."""

from __future__ import annotations

import base64
import gzip
import html
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any, Final

from ucon.core.files import canonical_json

#: Nothing is loaded from anywhere; pictures are made from the data.
_POLICY: Final = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src blob: data:; "
    "base-uri 'none'; form-action 'none'"
)


def asset(name: str) -> str:
    """Text of a file of ``ucon/pages/data/``."""
    return (files("ucon.pages") / "data" / name).read_text(encoding="utf-8")


def packed(value: Any) -> str:
    """Plain values as JSON, compressed, in base64."""
    return base64.b64encode(gzip.compress(canonical_json(value).encode(), 9, mtime=0)).decode()


def joined(parts: Sequence[bytes]) -> tuple[str, list[int]]:
    """Files joined into one, in base64, and where each ends, in bytes."""
    ends, at = [], 0
    for part in parts:
        at += len(part)
        ends.append(at)
    return base64.b64encode(b"".join(parts)).decode(), ends


def document(title: str, styles: Iterable[str], scripts: Iterable[str], data: Mapping[str, str]) -> str:
    """Text of the file.

    Args:
        title: of the page.
        styles: names of style sheets.
        scripts: names of scripts, in their order.
        data: texts from :func:`packed` and :func:`joined` by name; scripts find each as the element with that id.
    """
    blocks = "\n".join(
        f'<script type="application/x-packed" id="{html.escape(k)}">{v}</script>' for k, v in data.items()
    )
    code = "\n".join(asset(name) for name in scripts)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<link rel="icon" href="data:,">
<style>
{"".join(asset(name) for name in styles)}</style>
</head>
<body>
<main id="page"><noscript>This page needs JavaScript; nothing is loaded from elsewhere.</noscript></main>
{blocks}
<script>
{code}
</script>
</body>
</html>
"""
