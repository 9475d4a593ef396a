from __future__ import annotations

import numpy as np
import pytest

from models.agents.frontier import FrontierAgent
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.body import PAPER_BODY, Body
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.actions import Action
from ucon.task.rules import RELEASED_CODE, RULES

RELEASED = Body.under(RELEASED_CODE)


def test_a_look_is_a_pitch_or_a_height() -> None:
    assert PAPER_BODY.eyes[-30] == (1.25, -30)
    assert PAPER_BODY.searching[0] == 0
    assert RELEASED.eyes == {0: (1.0, 0), -30: (0.5, 0), 30: (1.5, 0)}
    assert [RELEASED.look(h, 0) for h in (0.5, 1.0, 1.5)] == [-30, 0, 30]
    assert [PAPER_BODY.look(1.25, p) for p in (-60, 0, 30)] == [-60, 0, 30]


@pytest.mark.parametrize("task", RULES)
def test_the_map_follows_the_camera(task: str) -> None:
    """Whatever LookUp and LookDown do, floor that is seen is mapped at floor height."""
    env = UcONEnv("mini", task=task, observe="symbolic", detector=True, habit_level="none")
    obs, info = env.reset(options={"episode": 0})
    known = SemanticMap(Body.of(info))
    for action in (Action.LOOK_DOWN, Action.ROTATE_LEFT, Action.LOOK_UP, Action.LOOK_UP, Action.ROTATE_LEFT, 0, 0):
        known.update(obs, info)
        obs, _, _, _, info = env.step(int(action))
    assert known.floor.sum() > 20
    assert {view.pitch_deg for view in known.views} == {-30, 0, 30}
    things = known.box[: known.n_tracks]
    things = things[(known.kind[: known.n_tracks] == 0) & (things[:, 3] >= things[:, 0])]
    assert len(things) > 2
    assert np.abs(things[:, 2].min()) < 0.05, "the lowest of what stands on the floor stands on the floor"


def test_frontier_searches_under_the_released_rules() -> None:
    env = UcONEnv("mini", task=RELEASED_CODE.name, observe="symbolic", detector=True, habit_level="none")
    agent, found = FrontierAgent(), 0
    for number in range(6):
        obs, info = env.reset(options={"episode": number})
        agent.reset([info])
        ended = False
        while not ended:
            obs, _, terminated, truncated, info = env.step(agent.act([obs], [info])[0])
            ended = terminated or truncated
        found += info["episode_metrics"]["success"]
    assert found >= 2
