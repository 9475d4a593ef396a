"""The report of lives in headless Chromium, with real clicks and keys."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.pages.conftest import contrast, wider_than_the_window
from tests.pages.lives import DAYS, EACH
from tests.pages.report.test_report import values_of
from tests.pages.report.test_report_in_browser import HOSTILE, opened
from ucon.pages.document import packed

ASKS = "#life .calendar .ask"


def test_the_calendar_shows_every_request(browser_page: Any, life_report: Path) -> None:
    page = opened(browser_page, life_report)
    rows, other = (values_of(life_report, f"life-{k}")["runs"][0] for k in range(2))
    assert page.locator(ASKS).count() == EACH
    assert page.locator(f"{ASKS}.lost").count() == sum(not row["found"] for row in rows)
    assert other[0]["target"] != rows[0]["target"]
    assert page.locator(".calendar thead th").count() == DAYS
    assert page.locator(".calendar thead th.changed").inner_text().split()[-1] == str(DAYS)
    page.get_by_label("Life", exact=True).select_option("1")
    page.wait_for_selector(f"{ASKS}[data-order='0'][data-thing='{other[0]['target']}']")
    assert page.locator(f"{ASKS}.lost").count() == sum(not row["found"] for row in other)


def test_requests_are_reached_by_keys_and_choose_their_thing(browser_page: Any, life_report: Path) -> None:
    page, rows = opened(browser_page, life_report), values_of(life_report, "life-0")["runs"][0]
    assert page.locator(f"{ASKS}[tabindex='0']").count() == 1  # one stop for the Tab key
    page.locator(f"{ASKS}[tabindex='0']").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    row = rows[2]
    said = page.inner_text("#life .panel >> nth=0 >> .ask-line")
    assert f"{row['target'].replace('_', ' ')} for person {row['user'] + 1}" in said
    assert (f"found in {row['steps']} steps, SPL {row['spl']:.2f}" in said) == row["found"]
    page.keyboard.press("Enter")
    assert page.get_by_label("Thing", exact=True).input_value() == row["target"]
    asked = sum(one["target"] == row["target"] for one in rows)
    assert page.locator(f"{ASKS}.chosen").count() == page.locator(".timeline .request").count() == asked
    page.keyboard.press("End")
    assert page.evaluate("document.activeElement.dataset.order") == str(EACH - 1)


def test_a_thing_is_followed_with_what_was_believed(browser_page: Any, life_report: Path) -> None:
    page, told = opened(browser_page, life_report), values_of(life_report, "life-0")
    rows = told["runs"][0]
    name = next(row["target"] for row in rows if row["believed"])
    mine, thing = [r for r in rows if r["target"] == name], next(t for t in told["things"] if t["name"] == name)
    page.get_by_label("Thing", exact=True).select_option(name)
    labels = page.locator("#thing .places > div").all_text_contents()
    assert (labels[0], labels[-1]) == ("asked for", "elsewhere")
    assert [label.removesuffix(" (by mistake)") for label in labels[1:-1]] == thing["places"]
    dots = page.locator(".timeline .held")
    assert dots.count() == sum(len(row["believed"]) for row in mine) > 0
    shares = sorted(float(dot.get_attribute("fill-opacity")) for dot in dots.all())
    assert shares == pytest.approx(sorted(p for row in mine for _, p, _ in row["believed"]))
    page.locator(".timeline .request >> nth=-1").focus()
    said = page.inner_text("#thing .ask-line")
    for _, p, words in mine[-1]["believed"]:
        assert f"{100 * p:.0f} % {words}".strip() in said
    points = page.locator(".timeline .truth").get_attribute("points").split()
    assert len(points) == 2 * len(thing["at"])
    page.get_by_label("Run", exact=True).select_option("1")
    page.wait_for_selector("#thing >> text=no beliefs")
    assert dots.count() == 0
    assert page.get_by_label("Thing", exact=True).input_value() == name


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [375, 1440])
def test_it_fits_and_can_be_read(browser_page: Any, life_report: Path, width: int, theme: str) -> None:
    page = browser_page
    page.set_viewport_size({"width": width, "height": 800})
    page.emulate_media(color_scheme=theme)
    opened(page, life_report)
    assert wider_than_the_window(page) == 0
    assert contrast(page, "p, td, th, h1, h2, h3, button, li, .places div, abbr, b") >= 4.5
    unnamed = page.evaluate(
        "[...document.querySelectorAll('button, select, [role=img]')].filter(e => "
        "!(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length)).length"
    )
    assert unnamed == 0


def test_hostile_words_are_shown_as_text(browser_page: Any, life_report: Path, tmp_path: Path) -> None:
    told = values_of(life_report, "life-0")
    row = next(row for row in told["runs"][0] if row["believed"])
    row["believed"] = [[-1, 0.5, HOSTILE[0]]]
    next(thing for thing in told["things"] if thing["name"] == row["target"])["places"][0] = HOSTILE[0]
    hostile = tmp_path / "hostile.html"
    hostile.write_text(re.sub(r'(id="life-0">)[^<]*', lambda m: m[1] + packed(told), life_report.read_text()))
    page = opened(browser_page, hostile)
    page.get_by_label("Thing", exact=True).select_option(row["target"])
    assert HOSTILE[0] in page.locator("#thing .places").text_content()
    page.locator(".timeline .request[aria-label*='script']").first.focus()
    assert HOSTILE[0] in page.locator("#thing .ask-line").text_content()
    assert page.locator("#thing script, #thing img").count() == 0
    assert "taken" not in page.title()
