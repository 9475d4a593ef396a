"""Two runs on the same three episodes, with and without reading habits; and two runs over the same lives."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.pages.lives import run_of_lives
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


@pytest.fixture(scope="session")
def life_runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two runs over two short lives: ``belief`` with a memory of sightings, and without memory."""
    out = tmp_path_factory.mktemp("lives")
    run_of_lives(out, "remembers", "agent=belief", "memory=sightings").play()
    run_of_lives(out, "forgets", "agent=belief", "memory=none").play()
    return out / "remembers", out / "forgets"


@pytest.fixture(scope="session")
def life_report(life_runs: tuple[Path, Path]) -> Path:
    """The report of both."""
    from ucon.__main__ import main

    out = life_runs[0].parent / "report.html"
    assert main(["report", *map(str, life_runs), "--out", str(out)]) == 0
    return out
