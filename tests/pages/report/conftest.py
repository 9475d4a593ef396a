"""Two runs on the same three episodes: one that believes, and one that reads no habits."""

from __future__ import annotations

from pathlib import Path

import pytest

from ucon.programs.two_searches import search_twice


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Folders of ``belief`` at retrieval, and of ``frontier``."""
    out = tmp_path_factory.mktemp("runs")
    words = ("episodes=mini", "limit=3")
    first = search_twice(("agent=belief", *words), out / "belief", ["retrieval"], films=False)[0].folder
    second = search_twice(("agent=frontier", *words), out / "frontier", ["none"], films=False)[0].folder
    return first, second


@pytest.fixture(scope="session")
def report(runs: tuple[Path, Path]) -> Path:
    """The report of both."""
    from ucon.__main__ import main

    out = runs[0].parent / "report.html"
    assert main(["report", *map(str, runs), "--out", str(out)]) == 0
    return out
