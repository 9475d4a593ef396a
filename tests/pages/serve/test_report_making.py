"""The report of a finished run, made from the page Runs and opened from there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.pages.serve.conftest import Listening
from ucon.evaluation.kept.record import read_records
from ucon.programs.two_searches import search_twice


def test_a_report_is_made_and_opened(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    words = ("agent=frontier", "episodes=mini", "limit=1")
    folder = search_twice(words, runs, ["none"], films=False)[0].folder
    served, page = listener.start(tmp_path / "out", (runs,)), browser_page
    page.goto(f"{served.address}runs")
    page.click(".link")
    page.click("#make-report")
    page.wait_for_selector("#report", timeout=120_000)
    assert (folder / "report.html").is_file()
    with page.context.expect_page() as opening:
        page.click("#report")
    report = opening.value
    report.wait_for_selector("html[data-ready]", state="attached")
    report.click("#list button.open")
    report.wait_for_selector("#episode img[src^='blob:']")
    report.keyboard.press("End")
    (record,) = read_records(folder)
    assert report.locator("#episode output").inner_text() == f"step {record.steps} / {record.steps}"


def test_why_a_report_cannot_be_made_is_said(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "train"
    folder.mkdir(parents=True)
    (folder / "metrics.jsonl").write_text('{"step":0,"val/score":-2.0}\nno line\n')
    served, page = listener.start(tmp_path / "out", (tmp_path / "runs",)), browser_page
    page.goto(f"{served.address}runs")
    page.click(".link")
    page.click("#make-report")
    page.wait_for_selector("text=not a line of metrics", timeout=60_000)
    assert str(tmp_path) not in page.content()
