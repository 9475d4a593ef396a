"""The pages in a real browser, with real keys and clicks."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.pages.conftest import contrast, wider_than_the_window
from tests.pages.serve.conftest import Listening, Served, seen
from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.evaluation.datasets.survey import read_key, read_sheet
from ucon.evaluation.kept.finished import FinishedRun
from ucon.habits import Habit, HabitDataset, book
from ucon.pages.serve.shell import PAGES
from ucon.pages.serve.studies import Studies
from ucon.task.sets import load_episodes

KEYS = {0: "ArrowUp", 1: "ArrowRight", 2: "ArrowLeft", 3: "w", 4: "s", 5: "o", 6: "f"}
#: Least contrast of text, WCAG AA.
CONTRAST = 4.5
#: Least frames per second in a walk.
FRAMES_PER_S = 15
HOSTILE = (
    "<img src=x onerror=document.title='owned'><script>document.title='owned'</script>",
    "'\"></li></ul><svg onload=document.title='owned'>&amp;{{7*7}}${7*7}",
    "before \u202e gnirts siht \u2066 after",
    "\u05d4\u05de\u05e4\u05ea\u05d7 \u0641\u064a \u0627\u0644\u0645\u0637\u0628\u062e",
    "bell \x07 escape \x1b[31m null \x00 delete \x7f end",
    "long " + "y" * 2**20,
    "joined\u200dzero\u200bwidth \U0001f468\u200d\U0001f469\u200d\U0001f467",
)


def hostile_book() -> HabitDataset:
    """The habit book with hostile sentences and household names in its first entries."""
    entries = list(book().entries)
    for number, text in enumerate(HOSTILE * 8):
        entry = entries[number]
        habits = (Habit(text, (0,)), *entry.habits[1:])
        entries[number] = replace(entry, habits=habits, household=f"who? {text[:300]}")
    return replace(book(), name="<b>hostile</b>", entries=tuple(entries))


def all_hostile(texts: list[str]) -> HabitDataset:
    """The habit book with only hostile sentences."""
    entries = [
        replace(entry, habits=tuple(Habit(texts[(k + j) % len(texts)], (0,)) for j in range(3)))
        for k, entry in enumerate(book().entries)
    ]
    return replace(book(), name="hostile", entries=tuple(entries))


def begin(page: Any, served: Served, n: int = 1, level: str = "retrieval") -> None:
    page.goto(f"{served.address}play")
    page.fill("#player", "ann")
    page.select_option("select >> nth=0", level)
    page.fill("input[type=number]", str(n))
    page.click("text=Begin")
    page.wait_for_selector(".pad")
    page.wait_for_selector(".habits li")


def steps_left(page: Any) -> int:
    return int(page.inner_text(".status b.figure"))


def press(page: Any, action: int) -> None:
    """Press an action's key and wait for its effect."""
    before = page.inner_text(".status b.figure")
    page.keyboard.press(KEYS[action])
    page.wait_for_function(
        "n => !document.querySelector('.pad') || document.querySelector('.status b.figure').textContent !== n",
        arg=before,
    )


def test_a_search_by_keys_is_a_run_like_any_other(browser_page: Any, served: Served, capsys: Any) -> None:
    episode, page = load_episodes("mini")[0], browser_page
    begin(page, served)
    assert "blackboard eraser" in page.inner_text(".status")
    assert page.locator(".habits li").count() == 20
    page.fill("#habit-search", "eraser")
    page.wait_for_selector(".habits mark")
    page.keyboard.press("f")  # in a text field it is a letter, not an action
    page.fill("#habit-search", "")
    assert steps_left(page) == 300
    page.click("h1")
    for action in map(int, episode.solution):
        press(page, action)
    assert seen(page, "#ending") == "Found the blackboard eraser"
    assert page.locator("svg.plan .path").count() == 2
    page.keyboard.press("Enter")  # the continue button has the focus
    assert seen(page, "#finished") == "The search is done"
    page.click("text=Map")
    assert seen(page, "#ending") == "Found the blackboard eraser"
    folder = served.out / "play" / "ann" / "mini-retrieval-1"
    run = FinishedRun.read(folder)
    assert run.records is not None
    assert (run.label, run.records[0].actions, run.records[0].spl) == ("human, retrieval", episode.solution, 1.0)
    assert main(["verify", str(folder)]) == 0
    assert "the checksums are right" in capsys.readouterr().out


def test_a_search_by_buttons_is_left_and_gone_on_with(browser_page: Any, served: Served) -> None:
    page = browser_page
    begin(page, served, n=2, level="none")
    assert "none are given at this level" in page.inner_text(".habits")
    page.click("[data-action='0']")
    page.wait_for_function("() => document.querySelector('.status b.figure').textContent === '299'")
    page.click("text=Leave")
    page.click("text='Continue'")
    page.wait_for_selector(".pad")
    assert steps_left(page) == 299
    page.click("[data-action='6']")
    assert seen(page, "#ending").startswith("Not found")
    assert "You said Found it at step 2, but the" in page.inner_text(".result")
    page.click("text=Next search")
    page.wait_for_selector(".pad")
    assert "search 2 of 2, found 0 of 1" in page.inner_text(".status")


def test_a_study_to_its_export(browser_page: Any, served: Served, capsys: Any) -> None:
    page = browser_page
    page.goto(f"{served.address}study")
    page.fill("#study-name", "one")
    page.fill("#study-n", "6")
    page.click("text=Create the study")
    for rater, answers in (("ann", "4y5n3u2y1n5y"), ("bob", "4y4n3u3y2n4n")):
        page.fill("#rater", rater)
        page.click("[aria-label='Answer one']")
        page.wait_for_selector("#habit")
        for number in range(6):
            page.keyboard.press(answers[2 * number])
            if rater == "ann" and number == 2:  # saved answers are there after a reload
                page.wait_for_selector("#saved:text-is('saved')")
                page.reload()
                page.click("[aria-label='Answer one']")
                page.wait_for_selector("input[name=real]:checked")
            page.keyboard.press(answers[2 * number + 1])
            page.keyboard.press("Enter")
        assert "All items are answered" in seen(page, "#thanks")
        with page.expect_download() as loading:
            page.click("text=Your sheet")
        loading.value.save_as(served.out / f"{rater}.csv")
        page.click("text=Back to the studies")
    page.click("[aria-label='Figures of one']")
    assert "2 raters, 6 items" in seen(page, "#figures")
    alpha = page.inner_text("tr:has-text('alpha, look') td >> nth=1")
    page.click("summary")
    with page.expect_download() as loading:
        page.click("text=The key")
    loading.value.save_as(served.out / "key.csv")
    sheets = [str(served.out / f"{rater}.csv") for rater in ("ann", "bob")]
    key = read_key(served.out / "key.csv")
    said = [(one.real, one.look) for one in read_sheet(Path(sheets[0]), key)]
    assert said == [(4, "yes"), (5, "no"), (3, "unsure"), (2, "yes"), (1, "no"), (5, "yes")]
    assert main(["habits", "survey", "score", str(served.out / "key.csv"), *sheets, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert f"{figures['alpha_look']['mean']:.3f}" == alpha


def test_an_answer_is_of_whoever_gave_it(browser_page: Any, served: Served) -> None:
    """Even one that is sent when another rater has already begun."""
    page = browser_page
    page.goto(f"{served.address}study")
    page.fill("#study-name", "one")
    page.fill("#study-n", "4")
    page.click("text=Create the study")
    page.fill("#rater", "ann")
    page.click("[aria-label='Answer one']")
    page.wait_for_selector("#habit")
    page.evaluate(
        "() => { const own = tell, going = new Promise(go => { window.go = go; });"
        "tell = async (...given) => { await going; return own(...given); }; }"
    )
    page.keyboard.press("4")
    page.keyboard.press("y")  # waits for the first request, which is held up
    page.click("text=Leave")
    page.fill("#rater", "bob")
    page.click("[aria-label='Answer one']")
    page.wait_for_selector("#done:has-text('as bob')")
    page.evaluate("async () => { go(); await saving; }")
    folder = served.out / "studies" / "one"
    assert [path.name for path in (folder / "sheets").iterdir()] == ["ann.csv"]
    first = read_sheet(folder / "sheets" / "ann.csv", read_key(folder / "key.csv"))[0]
    assert (first.real, first.look) == (4, "yes")


@pytest.mark.timed
def test_a_walk_is_fluent(browser_page: Any, served: Served) -> None:
    page = browser_page
    page.goto(f"{served.address}homes")
    page.wait_for_selector("#walk[data-frames]")
    page.wait_for_timeout(300)
    best, before = 0.0, page.evaluate("[pose.x, pose.y, pose.yaw]")
    for keys in (("ArrowUp",), ("ArrowLeft", "ArrowUp"), ("ArrowRight", "ArrowUp")):
        first, since = int(page.get_attribute("#walk", "data-frames")), time.perf_counter()
        for key in keys:
            page.keyboard.down(key)
        page.wait_for_timeout(900)
        frames = int(page.get_attribute("#walk", "data-frames")) - first
        best = max(best, frames / (time.perf_counter() - since))
        for key in keys:
            page.keyboard.up(key)
    x, y, yaw = page.evaluate("[pose.x, pose.y, pose.yaw]")
    assert (x - before[0]) ** 2 + (y - before[1]) ** 2 > 0.25
    assert yaw != before[2]
    assert page.evaluate("isFree(pose.x, pose.y)")
    assert best >= FRAMES_PER_S, f"{best:.1f} frames a second"


def test_things_have_cards(browser_page: Any, served: Served) -> None:
    page = browser_page
    page.goto(f"{served.address}homes#Merom_1_int")
    page.wait_for_selector("#walk[data-frames]")
    page.fill("#thing-search", "fridge")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert seen(page, "#card h2") == "fridge"
    card = page.inner_text("#card")
    assert "opens\nyes" in card
    assert "inside: " in card
    page.click("text=Go there")
    page.wait_for_function("() => !dirty && !asking")
    closed = page.evaluate("canvas.toDataURL()")
    page.click("text=Open it")
    page.wait_for_function("was => canvas.toDataURL() !== was", arg=closed)
    page.wait_for_function("() => !dirty && !asking")
    page.click("svg.plan rect.thing >> nth=0")
    page.wait_for_function("() => document.querySelector('#card h2').textContent !== 'fridge'")
    page.click("#walk")  # picks what is in the middle of the picture
    page.wait_for_function("() => document.querySelector('#card h2').textContent === 'fridge'")


def test_habits_are_searched_and_found_on_the_plan(browser_page: Any, served: Served) -> None:
    page = browser_page
    page.goto(f"{served.address}habits")
    page.wait_for_selector(".sentence")
    page.select_option("#category", "mug")
    page.fill("#habit-search", "dishwasher")
    page.wait_for_function("() => document.querySelectorAll('.sentence').length < 20")
    page.check("#possible")
    page.wait_for_selector(".sentence mark")
    page.focus(".sentence >> nth=0")
    page.keyboard.press("Enter")
    page.wait_for_selector("#where blockquote")
    assert "dishwasher" in page.inner_text("#where blockquote").lower()
    assert "yes" in page.inner_text("#where ul")
    page.fill("#habit-search", "no such words at all")
    assert "no sentence with these words" in seen(page, "#sentences li.faint")


def test_hostile_text_is_text(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    """Hostile text does not become an element, run, hide its neighbours or break the page."""
    served, page = listener.start(tmp_path / "out", (tmp_path,), hostile_book()), browser_page
    page.goto(f"{served.address}habits")
    page.wait_for_selector(".sentence")
    for words, expected in (
        ("onerror", "<img src=x onerror=document.title='owned'><script>"),
        ("svg onload", "</li></ul><svg onload="),
        ("siht", "gnirts siht"),
        ("escape null", "bell \u2407 escape \u241b[31m null \u2400 delete \u2421 end"),
        ("yyyyyyyy", "long yyyyyyyyyy"),
    ):
        page.fill("#habit-search", words)
        first = "text => document.querySelector('.sentence:has(mark)')?.innerText.includes(text)"
        page.wait_for_function(first, arg=expected)
        page.click(".sentence >> nth=0")
        assert expected in seen(page, "#where blockquote")
        assert wider_than_the_window(page) == 0
    page.click("#where button")
    assert len(seen(page, "#where .whole-text")) >= 2**20
    assert page.locator("main img, main script, #sentences svg").count() == 0
    assert page.title() == "Habits · UcON"


def test_hostile_text_in_a_study(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    """Hostile sentences as items, in the sheet and in the figures; an overlong sentence is refused."""
    texts, page = [text for text in HOSTILE if len(text) < 1000], browser_page
    served = listener.start(tmp_path / "out", (tmp_path,), all_hostile(texts))
    page.goto(f"{served.address}study")
    page.fill("#study-name", "one")
    page.fill("#study-n", "9")
    page.click("text=Create the study")
    page.fill("#rater", "ann")
    page.click("[aria-label='Answer one']")
    shown = set()
    for _ in range(9):
        shown.add(seen(page, "#habit"))
        page.keyboard.press("3")
        page.keyboard.press("n")
        page.keyboard.press("Enter")
    assert "All items are answered" in seen(page, "#thanks")
    assert any("<script>" in text for text in shown)
    assert any("\u2407" in text for text in shown)
    assert page.locator("main img, main script").count() == 0
    page.wait_for_selector("text=Your sheet")
    folder = served.out / "studies" / "one"
    assert len(read_sheet(folder / "sheets" / "ann.csv", read_key(folder / "key.csv"))) == 9
    assert page.title() == "Study · UcON"
    with pytest.raises(ConfigError, match="a sentence of 1048581 characters"):
        Studies(tmp_path, all_hostile([HOSTILE[5]])).make("long", 4, 0)


def test_runs_are_shown_while_they_grow(browser_page: Any, listener: Listening, tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    folder = runs / "<i>train</i>"
    folder.mkdir(parents=True)
    metrics = folder / "metrics.jsonl"
    metrics.write_text('{"step":0,"val/score":-2.0}\n{"loss":3.5,"step":1}\n{"loss":2.5,"step":2}\n')
    (folder / "report.html").write_text("<h1>Report</h1><script>document.title='a report'</script>")
    served, page = listener.start(tmp_path / "out", (runs,)), browser_page
    page.goto(f"{served.address}runs")
    assert "<i>train</i>" in seen(page, ".link")
    page.click(".link")
    assert seen(page, "#progress") == "2 steps"
    with metrics.open("a") as file:
        file.write('{"loss":1.5,"step":3}\n{"loss":1.25,')
    page.wait_for_function("() => document.getElementById('progress').textContent === '3 steps'")
    assert "loss: 1.5 at step 3" in (page.get_attribute("svg.chart", "aria-label") or "")
    with page.context.expect_page() as opening:
        page.click("text=Open the report")
    report = opening.value
    report.wait_for_load_state()
    assert report.title() == "a report"
    assert report.evaluate("self.origin") == "null"


#: An element of each page that shows that it is ready.
READY = {
    "": ".cards", "runs": "#detail p", "homes": "#walk[data-frames]", "habits": ".sentence", "play": "#player",
    "study": "#study-name",
}  # fmt: skip
TEXTS = "main :is(p, h1, h2, h3, td, th, li, label, button, span, b, dt, dd, legend), header :is(a, button)"


def check_looks(page: Any, where: str) -> None:
    """Check that nothing scrolls sideways at 375 and 1440 pixels, and that all text has contrast in light and dark."""
    for width in (375, 1440):
        page.set_viewport_size({"width": width, "height": 800})
        assert wider_than_the_window(page) == 0, (where, width)
    for colours in ("light", "dark"):
        page.emulate_media(color_scheme=colours)
        assert contrast(page, TEXTS) >= CONTRAST, (where, colours)


def test_who_plays_under_anothers_name_is_told(browser_page: Any, served: Served) -> None:
    first = browser_page
    begin(first, served, level="none")
    second = first.context.new_page()
    begin(second, served, level="none")
    for page in (first, second):
        page.click("[data-action='1']")
        page.wait_for_function("() => document.querySelector('.status b.figure').textContent === '299'")
    second.wait_for_function("() => document.querySelector('.message').textContent.includes('else is playing')")
    assert first.inner_text(".message") == ""
    second.close()


def test_pages_fit_and_can_be_read(browser_page: Any, served: Served) -> None:
    page = browser_page
    nameless = "e => !(e.labels?.length || e.getAttribute('aria-label'))"
    for name in ("", *PAGES):
        page.goto(f"{served.address}{name}")
        page.wait_for_selector(READY[name])
        check_looks(page, name)
        assert page.evaluate(f"[...document.querySelectorAll('input, select')].filter({nameless}).length") == 0, name
    begin(page, served, level="none")
    check_looks(page, "a search")
    page.keyboard.press("f")
    page.wait_for_selector("#ending")
    check_looks(page, "its end")


def test_colours_are_chosen_and_the_keyboard_is_enough(browser_page: Any, served: Served) -> None:
    page = browser_page
    page.goto(served.address)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    for _ in range(7):
        page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "theme"
    assert float(page.evaluate("parseFloat(getComputedStyle(document.activeElement).outlineWidth)")) >= 2
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")
    assert page.inner_text("#theme") == "Colours: dark"
    page.goto(f"{served.address}play")
    page.wait_for_selector("#player")
    assert page.get_attribute("html", "data-theme") == "dark"
