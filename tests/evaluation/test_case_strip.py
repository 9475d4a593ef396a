"""Figures of cases and of homes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ucon.__main__ import main
from ucon.evaluation.figures.case_strip import MOST_WAYPOINTS, Strip, Waypoint, chosen_steps, draw_case
from ucon.evaluation.figures.floor_drawing import Floor
from ucon.evaluation.figures.home_picture import draw_home
from ucon.sim.arrangement import Arrangement
from ucon.sim.cache import load_house
from ucon.sim.state import SceneState


@pytest.mark.parametrize(
    ("decided", "end", "steps"),
    [
        ([], 9, [0, 9]),
        ([0, 4], 9, [0, 4, 9]),
        ([0, 3, 3, 9], 9, [0, 3, 9]),
        ([0, *range(10, 90, 10)], 100, [0, 10, 30, 60, 80, 100]),
        ([5], 0, [0]),
    ],
)
def test_waypoints_are_the_first_the_last_and_decisions_between(decided: list[int], end: int, steps: list[int]) -> None:
    assert chosen_steps(decided, end) == steps
    assert len(steps) <= MOST_WAYPOINTS


def colors_of(path: Path) -> set[tuple[int, ...]]:
    return {tuple(color) for color in np.unique(np.array(Image.open(path).convert("RGB")).reshape(-1, 3), axis=0)}


def test_a_case_shows_frames_paths_and_the_target(tmp_path: Path) -> None:
    house = load_house("Rs_int")
    floor = Floor(house, SceneState(house, Arrangement()).boxes, tuple(room.name for room in house.spec.rooms))
    x0, y0, x1, y1 = house.spec.rooms[0].rect
    path = np.array([(x0 + 0.5, y0 + 0.5), (x1 - 0.5, y1 - 0.5)])
    frame = np.full((8, 8, 3), (1, 200, 3), np.uint8)
    point = Waypoint(0, (x0 + 0.5, y0 + 0.5), frame, "begins")
    strips = [Strip("told nothing", (point,), path), Strip("told all", (point, point), path)]
    draw_case("find it", "“It is there.”", strips, floor, house.categories.index("bed"), tmp_path / "a" / "case.png")
    found = colors_of(tmp_path / "a" / "case.png")
    assert {(1, 200, 3), (214, 60, 48), (15, 118, 110), (217, 119, 6)} <= found, "frame, target, both paths"


def test_a_home_is_drawn_with_its_rooms(tmp_path: Path) -> None:
    house = load_house("Rs_int")
    draw_home(house, Arrangement(), [room.name for room in house.spec.rooms], "Rs", tmp_path / "home.png")
    picture = Image.open(tmp_path / "home.png")
    assert picture.width > picture.height
    assert len(colors_of(tmp_path / "home.png")) > 1000, "what a camera sees"


def test_without_runs_the_command_says_what_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cases"]) == 2
    assert "or --figure" in capsys.readouterr().err


@pytest.mark.slow
def test_cases_are_played_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cases", "--figure", str(tmp_path), "--task", "paper"]) == 0
    told = capsys.readouterr().out
    for name in ("case_book", "case_newspaper"):
        assert Image.open(tmp_path / f"{name}.png").width > 1500
        assert f"{name}: a robot that reads the habit" in told
        for level in ("none", "retrieval"):
            assert (tmp_path / "runs" / f"{name}-{level}" / "episodes.jsonl").is_file()
