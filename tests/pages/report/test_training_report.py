"""The report of a training run: curves, card and configuration."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.pages.conftest import contrast, wider_than_the_window
from tests.pages.report.test_report import values_of
from ucon.__main__ import main

CARD = "# Model card\n<script>document.title = 'taken'</script>\n"


@pytest.fixture
def trained(tmp_path: Path) -> Path:
    """Folder of a training run with two validations and a partly written last line."""
    rows: list[dict[str, float]] = [{"step": k, "loss": 2.0 / k, "frames": 50.0 * k} for k in range(1, 1001)]
    rows += [{"step": 0, "val/success_rate": 0.1}, {"step": 1000, "val/success_rate": 0.4}]
    text = "".join(json.dumps(row) + "\n" for row in rows)
    (tmp_path / "metrics.jsonl").write_text(text + '{"step": 1001, "lo')
    (tmp_path / "config.yaml").write_text("agent: {}\n")
    (tmp_path / "MODEL_CARD.md").write_text(CARD)
    return tmp_path


def test_curves_are_those_of_the_log(trained: Path) -> None:
    assert main(["report", str(trained)]) == 0
    told = values_of(trained / "report.html", "index")
    assert told["steps"] == 1000
    assert told["card"] == CARD
    assert told["curves"]["val/success_rate"] == [[0, 0.1], [1000, 0.4]]
    loss = told["curves"]["loss"]
    assert len(loss) == 500  # every second step, so that at most 600 are left
    assert loss[0] == [2, 1.0]
    assert loss[-1] == [1000, 0.002]


def test_it_is_read_in_a_browser(browser_page: Any, trained: Path) -> None:
    main(["report", str(trained)])
    page = browser_page
    page.set_viewport_size({"width": 375, "height": 800})
    page.goto((trained / "report.html").as_uri())
    page.wait_for_selector("html[data-ready]", state="attached")
    assert "success rate" in page.locator(".panel h3 >> nth=0").inner_text()
    assert page.locator(".chart .line").count() == 2
    page.click("summary:has-text('more curves')")
    page.wait_for_selector(".chart .line >> nth=2", state="attached")
    assert CARD in page.locator("pre").nth(0).text_content()
    assert "taken" not in page.title()
    assert wider_than_the_window(page) == 0
    assert contrast(page, "p, h1, h2, h3, pre, summary") >= 4.5


def test_a_run_without_a_step_and_two_runs_are_refused(
    trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", str(trained), str(trained)]) == 2
    (trained / "metrics.jsonl").write_text("")
    assert main(["report", str(trained)]) == 2
    (trained / "metrics.jsonl").write_text("no metrics\n")
    assert main(["report", str(trained)]) == 2
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert len(said) == 3
    assert "give it alone" in said[0]
    assert "no training step yet" in said[1]
    assert ":1: not a line of metrics" in said[2]


def test_a_diverged_run_can_be_read(browser_page: Any, trained: Path) -> None:
    (trained / "metrics.jsonl").write_text('{"loss":2.0,"step":1}\n{"loss":1.0,"step":2}\n{"loss":NaN,"step":3}\n')
    assert main(["report", str(trained)]) == 0
    assert values_of(trained / "report.html", "index")["curves"]["loss"] == [[1, 2.0], [2, 1.0]]
    browser_page.goto((trained / "report.html").as_uri())
    browser_page.wait_for_selector("html[data-ready] .chart", state="attached")
