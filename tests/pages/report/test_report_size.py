"""Large reports: 50 episodes with every picture, and 1,000 without, stay small and open quickly."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from ucon.__main__ import main
from ucon.programs.two_searches import search_twice

pytestmark = [pytest.mark.slow, pytest.mark.timed]
ROOT = Path(__file__).resolve().parents[3]


def test_fifty_episodes_with_every_picture(tmp_path: Path) -> None:
    folder = search_twice(("agent=belief", "episodes=mini"), tmp_path, ["retrieval"], films=False)[0].folder
    assert main(["report", str(folder), "--pictures", "all"]) == 0
    assert (folder / "report.html").stat().st_size <= 8e6


def test_a_thousand_episodes_open_in_two_seconds(browser_page: Any, tmp_path: Path) -> None:
    out, page = tmp_path / "report.html", browser_page
    assert main(["report", str(ROOT / "results" / "learned-frontier"), "--out", str(out)]) == 0
    assert out.stat().st_size <= 25e6
    started = time.perf_counter()
    page.goto(out.as_uri())
    page.wait_for_selector("html[data-ready]", state="attached")
    assert time.perf_counter() - started <= 2.0
    started = time.perf_counter()
    page.click("#list button.open >> nth=150")
    page.wait_for_selector("#episode .plan")
    assert time.perf_counter() - started <= 2.0
