"""Play in a real browser, by real keys and clicks, to a success."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.pages.conftest import contrast, wider_than_the_window
from tests.pages.serve.conftest import Listening, Served, seen
from ucon.__main__ import main
from ucon.evaluation.kept.finished import FinishedRun
from ucon.task.sets import load_episodes

KEYS = {0: "ArrowUp", 1: "ArrowRight", 2: "ArrowLeft", 3: "w", 4: "s", 5: "o", 6: "f"}


def begin(page: Any, served: Served, n: int = 1, level: str = "retrieval") -> None:
    page.goto(f"{served.address}play")
    page.fill("#player", "ann")
    page.select_option("select >> nth=0", level)
    page.fill("input[type=number]", str(n))
    page.click("text=Begin")
    page.wait_for_selector(".pad")


def left(page: Any) -> int:
    return int(page.inner_text(".status b.figure"))


def press(page: Any, action: int) -> None:
    """Press a key and wait for what it does."""
    before = left(page)
    page.keyboard.press(KEYS[action])
    page.wait_for_function("n => !document.querySelector('.pad') || document.querySelector('.status b.figure').textContent != n", arg=str(before))


def test_a_search_by_keys_is_a_run_like_any_other(browser_page: Any, served: Served, capsys: Any) -> None:
    episode, page = load_episodes("mini")[0], browser_page
    begin(page, served)
    assert "blackboard eraser" in page.inner_text(".status")
    assert page.locator(".habits li").count() == 20
    page.fill("#habit-search", "eraser")
    page.wait_for_selector(".habits mark")
    page.keyboard.press("f")  # in a field it is a letter, no action
    page.fill("#habit-search", "")
    assert left(page) == 300
    page.click("h1")
    for action in map(int, episode.solution):
        press(page, action)
    assert seen(page, "#ending") == "Found the blackboard eraser"
    assert page.locator("svg.plan .path").count() == 2
    page.click("text=To the figures")
    assert "All 1 searches are done" in seen(page, "#finished")
    folder = served.out / "play" / "ann" / "mini-retrieval-1"
    run = FinishedRun.read(folder)
    assert run.records is not None
    assert (run.label, run.records[0].actions, run.records[0].spl) == ("human, retrieval", episode.solution, 1.0)
    assert main(["verify", str(folder)]) == 0
    assert main(["watch", str(folder)]) == 0
    assert "blackboard_eraser" in capsys.readouterr().out
