"""Every shipped policy, filmed as by ``eval.py pictures=1``: the videos show what it thinks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from models.agents.checkpoint import SHIPPED
from tests.evaluation.records import record
from tests.models.playing import CONFIGS, config_of
from ucon.configuration.wiring import Factory
from ucon.evaluation.playing.jobs import play
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec, _captions
from ucon.task.rules import PAPER, RULES
from ucon.task.sets import load_episodes

STEPS, SIDE, STRIP = 10, 384, 26
BRIEF = replace(PAPER, name="brief", max_steps=STEPS)
AGENTS = [
    name
    for name in sorted(path.stem for path in (CONFIGS / "agent").glob("*.yaml"))
    if config_of(name)["agent"].get("checkpoint") == SHIPPED
]


def played(name: str, level: str, folder: Path | None) -> PlayedEpisode:
    """Play the first steps of an episode in a small home with the agent as it is configured."""
    config = config_of(name, f"habit_level={level}")
    episode = min(load_episodes("mini"), key=lambda e: (len(e.arrangement.objects), e.shortest_path_m < 4, e.id))
    env = Factory(config["env"] | {"task": BRIEF.name}, {"episodes": [episode]})
    spec = RunSpec(Factory(config["agent"]), env, level, films=folder)
    return next(play(spec, [(0, episode)]))


def thoughts(folder: Path) -> list[NDArray[np.uint8]]:
    """The panel next to camera and map in each frame of a folder's only film, (384, 384, 3)."""
    (film,) = folder.glob("*.webm")
    video, frames = cv2.VideoCapture(str(film)), []
    while (read := video.read())[0]:
        frames.append(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB)[STRIP:])
    assert {frame.shape for frame in frames} == {(SIDE, 3 * SIDE, 3)}
    return [frame[:, 2 * SIDE :] for frame in frames]


def ink(page: NDArray[np.uint8]) -> int:
    """Number of dark pixels in the text below the map."""
    return int((page[int(0.68 * SIDE) :].max(2) < 160).sum())


@pytest.mark.parametrize("name", AGENTS)
def test_a_film_shows_what_it_thinks(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(RULES, BRIEF.name, BRIEF)
    told, untold = (played(name, level, tmp_path / level) for level in ("gt", "none"))
    pages, without = thoughts(tmp_path / "gt"), thoughts(tmp_path / "none")
    assert len(pages) > told.record.steps > 1
    first, last = pages[0].astype(int), pages[told.record.steps - 1].astype(int)
    assert np.abs(first - last).max(2)[: SIDE // 2].mean() > 1  # its map grows
    blue = (last[..., 2] > last[..., 0] + 60) & (last[..., 2] > 150)
    assert blue.sum() > 20  # where it goes
    assert ink(pages[0]) > ink(without[0]) + 300  # which habits support that
    assert untold.record.n_habits == 0
    assert played(name, "gt", None).record == told.record  # filming does not change play


@pytest.mark.parametrize(
    ("success", "end"), [(True, "found in the fridge after 9 steps"), (False, "; it is in the fridge")]
)
def test_the_last_line_of_a_film_says_where_the_target_is(success: bool, end: str) -> None:
    lines = _captions(record(0, success=success, steps=9), "in the fridge")
    assert len(lines) == 10
    assert lines[-1].endswith(end)
    assert not [line for line in lines[:-1] if "fridge" in line]
