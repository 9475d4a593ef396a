"""Remembered places of the target, with a detector that never finds it: only depth shows if something is there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ucon.envs.frame import StartFrame
from ucon.envs.ucon_env import UcONEnv
from ucon.lives.meeting import object_boxes
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.recalled import Recalled
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.noise_rates import EXACT
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.search.remembered import RememberedPlaces
from ucon.search.searcher import Searcher
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


class AllButTheTarget(NoisyDetector):
    """An exact detector that never finds the target."""

    def __init__(self, target: str) -> None:
        super().__init__(EXACT)
        self.target = target

    def find(self, frame: Frame) -> Boxes:
        found = super().find(frame)
        return found.keep(np.array([k for k, name in enumerate(found.label) if name != self.target], np.int64))


#: Episodes of ``mini`` whose target is not in a container: a blackboard eraser, tongs, a bucket and a die.
IN_THE_OPEN = (0, 1, 30, 48)


def place_of(episode: Episode) -> Recalled:
    """The target's place as remembered by a robot that recognised it with certainty."""
    house, frame = load_house(episode.scene), StartFrame(episode.start)
    boxes = object_boxes(episode.target_object)
    corners = np.array([frame.point(end, house.grid) for end in (boxes[:, :3].min(0), boxes[:, 3:].max(0))])
    low, high = corners.min(0), corners.max(0)
    return Recalled(0.5 * (low + high)[None], np.array([0.9]), size=(high - low)[None])


def played(number: int, change: Any = None) -> tuple[dict[str, Any], Searcher]:
    """Search with a remembered place to the end; returns the last info and the searcher."""
    target = load_episodes("mini")[number].target_category
    env = UcONEnv("mini", observe="symbolic", detector=AllButTheTarget(target), habit_level="none")
    observation, info = env.reset(options={"episode": number})
    assert env.episode is not None
    recalled = place_of(env.episode)
    info = {**info, "recalled": recalled if change is None else change(recalled)}
    search = Searcher(info, Coverage(str(info["target"]), CoverageWeights()))
    over = False
    while not over:
        action = search.look(observation, info)
        action = search.choose(search.decision().best) if action is None else action
        observation, _, done, truncated, info = env.step(int(action))
        over = done or truncated
    env.close()
    return info, search


@pytest.mark.parametrize("number", IN_THE_OPEN)
def test_what_stands_at_its_place_is_the_target_though_no_detector_finds_it(number: int) -> None:
    info, search = played(number)
    assert info["is_success"]
    assert search.remembered is not None
    assert search.remembered.p[0] > 0.95


def test_a_place_that_turns_out_empty_is_believed_less_and_not_taken() -> None:
    """The remembered place is moved 0.6 m up, into the air."""
    info, search = played(IN_THE_OPEN[2], lambda one: replace(one, xyz=one.xyz + np.array([0.0, 0.0, 0.6])))
    assert not info["is_success"]
    assert search.remembered is not None
    assert search.remembered.p[0] < 0.9
    assert info["episode_metrics"]["failure_cause"] != "stopped_early"


def test_places_of_unknown_size_are_not_taken() -> None:
    info, _ = played(IN_THE_OPEN[2], lambda one: replace(one, size=np.zeros((1, 3))))
    assert not info["is_success"]


def test_an_unlikely_place_is_left_alone() -> None:
    info, _ = played(IN_THE_OPEN[2], lambda one: replace(one, p=np.array([0.05])))
    assert not info["is_success"]


def test_without_places_nothing_is_done() -> None:
    none = RememberedPlaces(Recalled(np.zeros((0, 3)), np.zeros(0)))
    assert none.act(None, None, None, 0.0, blocked=False) is None  # type: ignore[arg-type]
