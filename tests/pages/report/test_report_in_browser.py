"""The report in headless Chromium, with real clicks and keys; the fixture fails on errors and foreign requests."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.pages.conftest import contrast, wider_than_the_window
from tests.pages.report.test_report import packed_in, values_of
from ucon.evaluation.kept.record import read_records
from ucon.pages.document import packed

HOSTILE = (
    "<script>document.title = 'taken'</script><img src=x onerror=\"document.title='taken'\">",
    "\u202ethe mug is \u0645\u0631\u062d\u0628\u0627 backwards",
    "control \x00\x07\x1b[31m characters &lt; &amp; </script>",
    "x" * 1_000_000,
)


def opened(page: Any, path: Path) -> Any:
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-ready]", state="attached")
    return page


def test_an_episode_is_played_step_by_step(browser_page: Any, report: Path, runs: tuple[Path, Path]) -> None:
    page, record = opened(browser_page, report), read_records(runs[0])[0]
    page.click("#list button.open >> nth=0")
    page.wait_for_selector("#episode .plan")
    assert page.locator("#episode .side").count() == 2  # both runs, side by side
    output = page.locator("#episode output")
    longest = max(read_records(folder)[0].steps for folder in runs)
    assert output.inner_text() == f"step 0 / {longest}"
    first = page.locator("#episode img").nth(0).get_attribute("src")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    assert output.inner_text() == f"step 5 / {longest}"
    assert page.locator("#episode img").nth(0).get_attribute("src") != first
    drawn = page.locator("#episode .path:not(.ahead)").nth(0).get_attribute("points").split()
    assert len(drawn) == 6
    assert page.locator("#episode .heat").count() > 0
    page.keyboard.press("End")
    assert f"step {longest} / {longest}" == output.inner_text()
    said = page.locator("#episode .side").nth(0).inner_text()
    assert (f"found after {record.steps} steps" in said) == record.success
    page.locator("#episode input[type=range]").fill("3")
    assert output.inner_text() == f"step 3 / {longest}"
    page.locator("#episode .decisions button.to >> nth=2").click()
    step = values_of(report, "episode-0-0")["decisions"][2]["step"]
    assert output.inner_text() == f"step {step} / {longest}"
    page.click("#episode button.main")
    page.wait_for_timeout(800)
    page.click("#episode button.main")  # pauses
    assert int(output.inner_text().split()[1]) > step + 1
    page.keyboard.press("]")
    page.wait_for_url(re.compile("001$"))


def test_the_list_is_filtered_and_sorted(browser_page: Any, report: Path, runs: tuple[Path, Path]) -> None:
    page, records = opened(browser_page, report), [read_records(folder) for folder in runs]
    rows = page.locator("#list tbody tr")
    assert rows.count() == 3
    page.get_by_label("Ending").select_option("found")
    assert rows.count() == sum(a.success or b.success for a, b in zip(*records, strict=True))
    page.get_by_label("Ending").select_option("")
    page.get_by_label("Search episodes").fill(records[0][1].target.replace("_", " "))
    assert 1 <= rows.count() < 4
    page.get_by_label("Search episodes").fill("no such thing")
    assert rows.count() == 0
    page.get_by_label("Search episodes").fill("")
    page.get_by_label("Sort").select_option("steps")
    shown = [int(text) for text in page.locator("#list tbody td:nth-child(3)").all_inner_texts()]
    other = [int(text) for text in page.locator("#list tbody td:nth-child(6)").all_inner_texts()]
    longest = [max(pair) for pair in zip(shown, other, strict=True)]
    assert longest == sorted(longest, reverse=True)
    page.get_by_label("Group episodes by").select_option("home")
    assert "Beechwood_0_int" in page.locator("#groups").inner_text()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [375, 1440])
def test_it_fits_and_can_be_read(browser_page: Any, report: Path, width: int, theme: str) -> None:
    page = browser_page
    page.set_viewport_size({"width": width, "height": 800})
    page.emulate_media(color_scheme=theme)
    opened(page, report)
    page.click("#list button.open >> nth=0")
    page.wait_for_selector("#episode .plan")
    assert wider_than_the_window(page) == 0
    assert contrast(page, "p, td, th, h1, h2, h3, button, summary, li, .tag") >= 4.5
    unnamed = page.evaluate(
        "[...document.querySelectorAll('button, select, input, img, svg[role=img]')].filter(e => "
        "!(e.getAttribute('aria-label') || e.alt || e.textContent.trim() || e.labels?.length)).length"
    )
    assert unnamed == 0


def test_colours_can_be_chosen_by_keyboard_alone(browser_page: Any, report: Path) -> None:
    page = opened(browser_page, report)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "theme"
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    light = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != light


def test_hostile_text_is_shown_as_text(browser_page: Any, report: Path, tmp_path: Path) -> None:
    texts = values_of(report, "texts")
    given = values_of(report, "episode-0-0")["habits"]["given"]
    for k, text in enumerate(HOSTILE):
        texts[given[k]] = text
    hostile = tmp_path / "hostile.html"
    hostile.write_text(re.sub(r'(id="texts">)[^<]*', lambda m: m[1] + packed(texts), report.read_text()))
    assert packed_in(hostile).keys() == packed_in(report).keys()
    page = opened(browser_page, hostile)
    page.click("#list button.open >> nth=0")
    page.wait_for_selector("#episode .habits")
    for summary in page.locator("#episode .side >> nth=0").locator("summary", has_text="given").all():
        summary.click()
    page.wait_for_selector("#episode .side >> nth=0 >> .habits >> nth=2")
    shown = page.locator("#episode .side >> nth=0").locator(".habits .plain").all_text_contents()
    assert {HOSTILE[0], HOSTILE[1], HOSTILE[3]} <= set(shown)
    assert "taken" not in page.title()
    assert page.locator("#episode .habits script, #episode .habits img").count() == 0
    assert wider_than_the_window(page) == 0
