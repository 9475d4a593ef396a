"""The picture of what an agent thinks: where it is warm, its text, and that videos keep it to the end."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from models.agents.belief import BeliefAgent
from models.agents.frontier import FrontierAgent
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.playing import pictures
from ucon.evaluation.playing.pictures import save_film
from ucon.perception.belief.target_belief import Locations
from ucon.perception.drawing.overlay import habit_lines, wrapped
from ucon.search.picture import _lines, _mass_left, draw_search

BLUE, WARM = (36, 120, 200), (226, 92, 30)


def searching(agent: Any, steps: int) -> Any:
    """The searcher of an agent after some steps of an episode."""
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level="retrieval")
    obs, info = env.reset(options={"episode": 1})
    agent.reset([info])
    for _ in range(steps):
        obs, _, _, _, info = env.step(agent.act([obs], [info])[0])
    agent.act([obs], [info])
    return agent.controllers[0].searcher


def near(image: np.ndarray[Any, Any], color: tuple[int, int, int]) -> int:
    return int((np.abs(image.astype(int) - color).max(2) < 40).sum())


def somewhere(anchor: str, habits: tuple[str, ...] = ()) -> Any:
    """A reader that places the target by one anchor because of the last habit."""
    p = np.array([[0.0, 0.0, 0.0, 0.9]])
    said = np.eye(len(habits))[-1] if habits else np.zeros(0)
    return lambda info: Locations((anchor,), p, habits, said, lambda name: said * (name == anchor))


def test_it_is_warm_where_the_belief_is() -> None:
    believing = searching(BeliefAgent(), 12)
    anchor = believing.map.category[int(_mass_left(believing).sum(1).argmax())]
    sure = searching(BeliefAgent(somewhere(anchor)), 12)
    image = draw_search(sure)
    assert image.shape == (384, 384, 3)
    assert image.dtype == np.uint8
    assert near(image, WARM) > 20
    assert near(image, BLUE) > 20
    nowhere = searching(BeliefAgent(somewhere("no such thing")), 12)
    assert near(draw_search(nowhere), WARM) < near(image, WARM)


def test_it_says_what_it_believes_and_which_habit_says_so() -> None:
    searcher = searching(BeliefAgent(somewhere("no_such_thing", habits=("a", "b", "under the lamp"))), 5)
    lines = [text for text, _ in _lines(searcher, searcher.map, _mass_left(searcher), 436)]
    assert lines[0] == "believes: by no such thing 90%"
    assert lines[1].startswith("goes to: ")
    assert lines[2:] == ['100% "under the lamp"']


def test_who_reads_nothing_says_where_it_goes() -> None:
    searcher = searching(FrontierAgent(), 5)
    lines = _lines(searcher, searcher.map, _mass_left(searcher), 436)
    assert len(lines) == 1
    assert draw_search(searcher).shape == (384, 384, 3)


def test_the_two_strongest_habits_are_told_with_their_weight() -> None:
    told = [("weak", 0.01), ("a little", 0.2), ("much", 0.9), ("some", 0.5)]
    assert [line.text for line in habit_lines(told, 384)] == ['90% "much"', '50% "some"']
    long, *rest = [line.text for line in habit_lines([("word " * 60, 0.4)], 384)]
    assert long.startswith('40% "word')
    assert len(rest) == 1
    assert rest[0].endswith(' ..."')
    assert len(rest[0]) <= 52


def test_lines_are_not_too_long() -> None:
    text = "the blue mug is put on the rack by the window after breakfast"
    assert " ".join(wrapped(text, 20)) == text
    assert max(map(len, wrapped(text, 20))) <= 20


def test_videos_hold_thoughts_to_the_end(tmp_path: Path) -> None:
    """The last frame has no thought and keeps the previous one."""
    plain, thought = np.zeros((64, 128, 3), np.uint8), np.full((64, 64, 3), 200, np.uint8)
    frames = [np.concatenate([plain, thought], 1)] * 3 + [plain]
    _, film = save_film(frames, ["caption"] * 4, tmp_path, "film")
    video, last = cv2.VideoCapture(str(film)), None
    while (read := video.read())[0]:
        last = read[1]
    assert last is not None
    assert last.shape[1] == 192
    assert abs(float(last[40:, 140:].mean()) - 200) < 10


def test_without_pyav_there_is_the_map_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    pictures._pyav.cache_clear()
    try:
        for name in ("one", "two"):
            assert save_film([np.zeros((64, 128, 3), np.uint8)], ["caption"], tmp_path, name) == [
                tmp_path / f"{name}.png"
            ]
    finally:
        pictures._pyav.cache_clear()
    assert capsys.readouterr().err == "warning: no films, since the package av is missing; run `make setup`\n"


def test_lines_are_filled_and_long_words_left_whole() -> None:
    assert wrapped("aa bb cc dd", 5) == ["aa bb", "cc dd"]
    assert wrapped("aa bb cc dd", 6) == ["aa bb", "cc dd"]
    assert wrapped("aa unbreakable bb", 5) == ["aa", "unbreakable", "bb"]
    assert wrapped("", 5) == [""]
