"""A run over lives on the page Runs: while it is played, and its report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.pages.lives import EACH, run_of_lives
from tests.pages.serve.conftest import Listening
from tests.pages.serve.test_pages_data import asked, fresh, runs
from ucon.evaluation.kept.record import read_records
from ucon.pages.report.life_records import curves_of, rows_by_life


def test_lives_are_followed_while_they_are_played(tmp_path: Path) -> None:
    seen: list[list[int]] = []

    def on_played(_: Any) -> None:
        with fresh(tmp_path) as client:
            row = runs(client)[f"{tmp_path.name}/run"]
            detail = asked(client, "runs/one", run=row["id"])
        assert sum(map(len, detail["lives"].values())) == row["done"]
        assert detail["curves"] == []
        seen.append([len(rows) for rows in detail["lives"].values()])

    run_of_lives(tmp_path, "run", "agent=frontier", "memory=none").play(on_played)
    assert seen == [[n] for n in range(1, EACH + 1)] + [[EACH, n] for n in range(1, EACH + 1)]
    with fresh(tmp_path) as client:
        detail = asked(client, "runs/one", run=runs(client)[f"{tmp_path.name}/run"]["id"])
    records = read_records(tmp_path / "run")
    assert detail["finished"]
    assert detail["by_day"] == curves_of(records)
    assert detail["lives"] == rows_by_life(records)


def test_calendar_and_report_of_a_run(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    run_of_lives(tmp_path / "runs", "run", "agent=frontier", "memory=none").play()
    served, page = listener.start(tmp_path / "out", (tmp_path / "runs",)), browser_page
    page.goto(f"{served.address}runs")
    page.click(".link")
    page.wait_for_selector("#lives .calendar")
    lives = rows_by_life(read_records(tmp_path / "runs" / "run"))
    asks, (first, last) = page.locator("#lives .calendar .ask"), lives
    assert page.locator("#lives .calendar .ask.lost").count() == sum(not row["found"] for row in lives[last])
    page.get_by_label("Life", exact=True).select_option(first)
    assert asks.count() == EACH
    assert page.locator("#lives .calendar .ask.lost").count() == sum(not row["found"] for row in lives[first])
    assert page.locator("#lives .chart").count() == 2
    page.click("#make-report")
    page.wait_for_selector("#report", timeout=120_000)
    assert page.get_by_label("Life", exact=True).input_value() == first  # the choice is kept
    with page.context.expect_page() as opening:
        page.click("#report")
    report = opening.value
    report.wait_for_selector("html[data-ready]", state="attached")
    assert report.locator(".calendar .ask").count() == EACH
