"""Agents under ``task=real_robot``: those with maps search in six headings, those trained on quarter turns refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from models.agents.belief import BeliefAgent
from models.agents.l3mvn import L3MVNAgent
from models.agents.lgx import SIDES, LGXAgent
from models.agents.pixelnav import PixelNavAgent, mosaic
from models.agents.policy import PolicyAgent
from models.habit_policy_e2e import HabitPolicyE2E
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.language.models.encoder import EncoderModel
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.robot.rig import RobotRig

ACTIONS = ("move", "right", "left", "up", "down", "open", "done")


def robot(**options: Any) -> UcONEnv:
    given = {"task": "real_robot", "detector": True, "observe": "symbolic", "habit_level": "gt"}
    return UcONEnv("mini", **(given | options))


def played(env: UcONEnv, agent: Any, episode: int = 0, steps: int = 300) -> tuple[list[int], dict[str, Any]]:
    obs, info = env.reset(options={"episode": episode})
    agent.reset([info])
    done, actions = False, []
    while not done and len(actions) < steps:
        actions.append(int(agent.act([obs], [info])[0]))
        obs, _, terminated, truncated, info = env.step(actions[-1])
        done = terminated or truncated
    return actions, info


def test_a_search_finds_with_an_exact_robot_and_with_one_that_errs() -> None:
    for rig in (RobotRig.exact(), RobotRig()):
        agent = BeliefAgent()
        found = [played(robot(rig=rig), agent, k)[1].get("is_success", False) for k in (2, 4, 14)]
        assert sum(found) >= 2


def test_a_search_does_not_turn_to_and_fro() -> None:
    """A robot's moves end on edges of cells, where two ways of rounding can differ."""
    agent = BeliefAgent()
    for k in (0, 3, 10):
        actions, _ = played(robot(rig=RobotRig.exact(), habit_level="none"), agent, k)
        text = "".join(map(str, actions))
        assert "12" * 6 not in text


@pytest.mark.parametrize("make", [LGXAgent, PixelNavAgent, L3MVNAgent])
def test_agents_that_ask_look_in_six_directions(make: Any) -> None:
    agent = make(EncoderModel())
    actions, _ = played(robot(), agent, steps=40)
    assert actions[:5] == [2] * 5, "all around at first"
    assert 0 in actions[5:]


def test_the_six_directions_have_names_and_angles_of_their_own() -> None:
    env, agent = robot(observe="pixels"), LGXAgent(EncoderModel())
    obs, info = env.reset(options={"episode": 4})
    agent.reset([info])
    explorer = agent._explorers[0]
    while (action := explorer.look(obs, info)) is not None:
        obs, _, _, _, info = env.step(int(action))
    decision = explorer.decision()
    (question,) = agent.questions(decision, 0)
    names = [option.name for option in question.options]
    assert len(set(names)) == len(names) >= 2
    assert set(names) <= set(SIDES[6])
    assert decision.known.body.headings == 6


def test_the_picture_of_six_views_has_two_rows_of_three() -> None:
    env = robot(observe="pixels", rig=RobotRig.exact())
    obs, info = env.reset(options={"episode": 2})

    class Seeing(EncoderModel):
        sees_images = True

    agent = PixelNavAgent(Seeing(), inputs="images")
    agent.reset([info])
    explorer = agent._explorers[0]
    frames = []
    while (action := explorer.look(obs, info)) is not None:
        frames.append(obs["rgb"].copy())
        obs, _, _, _, info = env.step(int(action))
    frames.append(obs["rgb"].copy())
    picture = mosaic(explorer.decision())
    assert picture.shape == (2 * 128 + 10, 3 * 128 + 20, 3)
    assert (picture[45:128, :128] == frames[-1][45:]).all(), "it faces the last frame: angle 0"


def test_the_map_stands_where_the_odometry_says() -> None:
    env = robot(rig=RobotRig(odometry="exact"))
    obs, info = env.reset(options={"episode": 4})
    known = SemanticMap.of(info)
    for action in (0, 0, 2, 0, 0, 1, 0):
        known.update(obs, info)
        assert known.view.xy == pytest.approx(obs["pose"][:2], abs=1e-6)
        assert known.view.node_xy == pytest.approx(obs["pose"][:2], abs=0.1251)
        c, s = known.view.direction
        assert np.arctan2(s, c) == pytest.approx(float(obs["pose"][2]), abs=1e-5)
        obs, _, _, _, info = env.step(action)


def test_who_learned_quarter_turns_refuses() -> None:
    _, info = robot().reset(options={"episode": 0})
    agent = PolicyAgent(HabitPolicyE2E(), checkpoint="untrained")
    with pytest.raises(ConfigError, match=r"trained with turns of 90 degrees.*real_robot turns by 60"):
        agent.reset([info])
