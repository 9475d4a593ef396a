"""Every configured agent that knows no secrets: it does the same with the same, and reads nothing it may not."""

from __future__ import annotations

from itertools import pairwise

import pytest

from models.agents.asking import AskingAgent
from models.agents.waypoint import WaypointAgent
from tests.models.playing import HONEST, built, episodes, gone, play

CHOOSERS = [name for name in HONEST if isinstance(built(name)[0], WaypointAgent)]


def test_there_are_agents_to_test() -> None:
    assert {"lgx", "pixelnav", "pixelnav_images", "l3mvn"} <= set(CHOOSERS)
    assert {"belief", "frontier", "random"} <= set(HONEST)
    assert not {"oracle", "oracle_locations"} & set(HONEST)


@pytest.mark.parametrize("name", HONEST)
def test_an_unseen_target_changes_nothing(name: str) -> None:
    agent, env = built(name)
    compared = 0
    for episode in episodes(2):
        before = play(agent, env, episode, 80, unseen=True)
        assert play(agent, env, gone(episode), len(before)) == before
        compared += len(before)
    assert compared > 20


@pytest.mark.parametrize("name", HONEST)
def test_a_batch_is_its_parts(name: str) -> None:
    """Slots in any order, one episode ended and another begun in between."""
    agent, env = built(name)
    first, second = episodes(2)
    alone = [play(agent, env, episode, 60) for episode in (first, second)]
    assert play(agent, env, first, 60) == alone[0]
    agent, envs = built(name)[0], [env, built(name)[1]]
    frames = [e.reset(options={"episode": episode}) for e, episode in zip(envs, (first, second), strict=True)]
    agent.reset([frames[1][1]], slots=[7])
    agent.reset([frames[0][1]], slots=[3])
    together: list[list[int]] = [[], []]
    for _ in range(min(map(len, alone))):
        chosen = agent.act([f[0] for f in frames], [f[1] for f in frames], slots=[3, 7])
        for k, action in enumerate(chosen):
            together[k].append(action)
            obs, _, _, _, info = envs[k].step(action)
            frames[k] = obs, info
    assert together == [actions[: len(together[0])] for actions in alone]


@pytest.mark.parametrize("name", CHOOSERS)
def test_choices_are_recorded_and_walked_to(name: str) -> None:
    agent, env = built(name)
    assert isinstance(agent, WaypointAgent)
    for episode in episodes(2):
        actions = play(agent, env, episode)
        made = agent.decisions(0)
        assert [d.number for d in made] == list(range(len(made)))
        assert {d.episode for d in made} == {episode.id}
        assert len(made) >= 2
        assert all(a.step < b.step <= len(actions) for a, b in pairwise(made))
        assert all(d.chosen >= 0 for d in made)
        assert all(len(d.scores) in (0, len(d.options)) for d in made)
        asked = [d for d in made if d.asked]
        assert bool(asked) == isinstance(agent, AskingAgent)
        assert not any(d.fallback or d.failure for d in made)
        assert agent.language_usage(0)[0] == sum(d.asked for d in made)


@pytest.mark.parametrize("name", CHOOSERS)
def test_habits_matter_to_those_that_read_them(name: str) -> None:
    scores = []
    for level in ("none", "gt"):
        agent, env = built(name, level)
        assert isinstance(agent, WaypointAgent)
        scores.append([])
        for episode in episodes(2):
            play(agent, env, episode, 40)
            scores[-1] += [d.scores for d in agent.decisions(0)]
    assert (scores[0] != scores[1]) == agent.uses_habits
