"""Hooks of mkdocs: the site also has the pages of results/, and links that leave both become plain text."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
#: Pages beside docs/ that the site has, and where: docs/results.md is results/ already.
ELSEWHERE = {f"results/{path.name}": f"tables/{path.name}" for path in sorted((ROOT / "results").glob("*.md"))}
_LINK = re.compile(r"(?<!!)\[([^\]]*)\]\((?!https?:|#)([^)#]+)(#[^)]*)?\)")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages of results/."""
    from mkdocs.structure.files import File

    for page, name in ELSEWHERE.items():
        files.append(File.generated(config, name, abs_src_path=str(ROOT / page)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Point links to where their page is on the site; what is not on it is named without a link."""
    here = page.file.src_uri
    source = next((name for name, place in ELSEWHERE.items() if place == here), f"docs/{here}")

    def moved(match: re.Match[str]) -> str:
        text, target, anchor = match[1], match[2], match[3] or ""
        there = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        place = ELSEWHERE.get(there, there.removeprefix("docs/") if there.startswith("docs/") else None)
        if place is None:
            return text
        return f"[{text}]({posixpath.relpath(place, posixpath.dirname(here) or '.')}{anchor})"

    return _LINK.sub(moved, markdown)
