"""The report of a finished run, made and opened from the page Runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.pages.serve.conftest import Listening
from ucon.evaluation.kept.record import read_records
from ucon.pages.serve import report_maker
from ucon.pages.serve.report_maker import ReportMaker
from ucon.pages.serve.run_list import FoundRun, RunList
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


def test_what_a_click_is_answered_stays(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "train"
    folder.mkdir(parents=True)
    (folder / "metrics.jsonl").write_text('{"loss":2.5,"step":1}\n')
    served, page = listener.start(tmp_path / "out", (tmp_path / "runs",)), browser_page
    page.goto(f"{served.address}runs")
    page.click(".link")
    page.evaluate("() => { tell = async () => { throw new Error('another report is being made'); }; }")
    page.click("#make-report")
    page.wait_for_selector("text=another report is being made")
    for what in ("one", "list", "one"):
        with page.expect_response(lambda answer, what=what: f"/runs/{what}" in answer.url):
            pass
    assert page.is_visible("text=another report is being made")


@pytest.fixture
def trained(tmp_path: Path) -> FoundRun:
    """A training run, as the page Runs finds it."""
    (tmp_path / "train").mkdir()
    (tmp_path / "train" / "metrics.jsonl").write_text('{"loss":2.5,"step":1}\n')
    (run,) = RunList([tmp_path]).all()
    return run


@pytest.fixture
def as_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Lets a shell script run instead of the command that makes reports."""

    def run(script: str) -> None:
        path = tmp_path / "python"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        monkeypatch.setattr(report_maker.sys, "executable", str(path))

    return run


def fault(maker: ReportMaker, run: FoundRun) -> str:
    """Try to make a report, and return why it could not be made."""
    maker.make(run)
    until = time.monotonic() + 30
    while maker.state(run)["making"]:
        assert time.monotonic() < until
        time.sleep(0.01)
    return str(maker.state(run)["fault"])


def test_faults_may_be_any_bytes(trained: FoundRun, as_python: Callable[[str], None]) -> None:
    as_python("printf 'error: bad \\377 name\\n' >&2; exit 2")
    assert fault(ReportMaker(), trained) == "bad \ufffd name"


def test_a_report_that_takes_too_long_is_ended(
    trained: FoundRun, as_python: Callable[[str], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    as_python(f"echo $$ > {tmp_path}/id; exec sleep 600")
    monkeypatch.setattr(report_maker, "_PATIENCE_S", 2.0)
    assert "timed out" in fault(ReportMaker(), trained)
    with pytest.raises(ProcessLookupError):  # it was also waited for, so no zombie is left
        os.kill(int((tmp_path / "id").read_text()), 0)


def test_nothing_is_begun_when_the_server_has_ended(
    trained: FoundRun, as_python: Callable[[str], None], tmp_path: Path
) -> None:
    as_python(f"touch {tmp_path}/begun")
    maker = ReportMaker()
    maker.close()
    assert fault(maker, trained) == "the server has stopped"
    assert not (tmp_path / "begun").exists()
