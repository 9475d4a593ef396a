"""Near, views and rule sets."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.task.outcome import EpisodeOutcome
from ucon.task.rules import PAPER, RELEASED_CODE, task_rules

BOX = np.array([[1.0, 1.0, 0.0, 2.0, 2.0, 1.0]])


@pytest.mark.parametrize(
    ("xy", "paper", "released"),
    [
        ((1.5, 1.5), True, True),
        ((0.0, 1.5), True, False),
        ((-0.01, 1.5), False, False),
        ((0.3, 0.3), True, True),  # corner: 0.99 m away, 0.7 along each axis
        ((0.29, 0.29), False, False),
        ((2.7, 1.5), True, True),
    ],
)
def test_near(xy: tuple[float, float], paper: bool, released: bool) -> None:
    assert PAPER.near(np.array(xy), BOX)[0] == paper
    assert RELEASED_CODE.near(np.array(xy), BOX)[0] == released


def test_least_pixels_replace_those_of_the_rules() -> None:
    strict = task_rules("paper", 16)
    assert (strict.done_min_pixels, strict.open_min_pixels, strict.near_m) == (16, 16, PAPER.near_m)
    assert task_rules("paper", None) is PAPER
    with pytest.raises(ConfigError, match=r"env\.least_pixels=0: expected 1 or more"):
        task_rules("paper", 0)


def test_views() -> None:
    assert PAPER.views[0] == (0, 0)
    assert sorted(PAPER.views) == [(0, p) for p in (-60, -30, 0, 30, 60)]
    assert RELEASED_CODE.views == ((0, 0), (1, 0), (2, 0))


def test_unknown_task() -> None:
    with pytest.raises(ConfigError, match="did you mean paper"):
        task_rules("papers")


def _outcome(**change: object) -> EpisodeOutcome:
    base: dict = {
        "success": False,
        "steps": 300,
        "path_length_m": 8.0,
        "shortest_path_m": 4.0,
        "final_distance_m": 1.0,
        "start_distance_m": 4.0,
        "opens": 0,
        "containers_opened": 0,
        "collisions": 0,
        "first_seen_step": -1,
        "stopped": False,
        "in_reach": False,
        "contained": False,
        "container_opened": False,
    }
    return EpisodeOutcome(**(base | change))


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({}, "never_seen"),
        ({"contained": True}, "container_never_opened"),
        ({"contained": True, "container_opened": True}, "never_seen"),
        ({"first_seen_step": 9}, "seen_not_reached"),
        ({"first_seen_step": 9, "in_reach": True}, "out_of_steps"),
        ({"stopped": True}, "stopped_early"),
        ({"success": True, "stopped": True}, "none"),
    ],
)
def test_failure_cause(change: dict, cause: str) -> None:
    assert _outcome(**change).failure_cause == cause


def test_spl() -> None:
    assert _outcome(success=True).spl == pytest.approx(0.5)
    assert _outcome(success=True, path_length_m=3.0).spl == 1.0  # never above 1
    assert _outcome().spl == 0.0
    assert _outcome().soft_spl == pytest.approx(0.75 * 0.5)


def test_soft_spl_is_spl_where_it_succeeds_and_nothing_farther_away_than_at_first() -> None:
    assert _outcome(success=True).soft_spl == _outcome(success=True).spl == pytest.approx(0.5)
    assert _outcome(success=True, final_distance_m=3.0).soft_spl == pytest.approx(0.5)
    assert _outcome(final_distance_m=5.0).soft_spl == 0.0
    assert _outcome(final_distance_m=0.0, start_distance_m=0.0).soft_spl == pytest.approx(0.5)
