"""Every configured agent without privileged information: same input, same actions, and nothing else is read."""

from __future__ import annotations

from itertools import pairwise

import pytest

from models.agents.asking import AskingAgent
from models.agents.waypoint import Chosen, WaypointAgent
from tests.models.playing import HONEST, built, episodes, gone, play
from ucon.core.errors import ConfigError
from ucon.search import Decision

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
    """Slots in any order, after another episode in the same agent."""
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
def test_habits_change_a_tenth_of_the_choices(name: str) -> None:
    """Each choice in whole searches at gt is made twice, with and without habits, with the same random numbers."""
    agent, env = built(name, "gt")
    assert isinstance(agent, WaypointAgent)
    made = twice(agent) if isinstance(agent, AskingAgent) else []
    for episode in episodes(12):
        play(agent, env, gone(episode), 150)
    if not agent.uses_habits:
        assert not made
        return
    if not isinstance(agent, AskingAgent):
        pytest.skip("it asks no model, so the same choice cannot be asked for without habits")
    changed = sum(a.number != b.number for a, b in made)
    assert len(made) > 60
    assert 0.1 * len(made) <= changed < len(made)


def twice(agent: AskingAgent) -> list[tuple[Chosen, Chosen]]:
    """Record the choices for which an agent with one slot asks its model: as made, and as made without habits."""
    heard: list[tuple[Chosen, Chosen]] = []
    choose = agent.choose

    def listen(decisions: list[Decision], slots: list[int]) -> list[Chosen]:
        (decision,), (slot,) = decisions, slots
        random, told = decision.draw.bit_generator.state, agent._constant_prompt[slot]
        agent._write_constant_prompt(slot, told[0], ())
        without = choose(decisions, slots)
        decision.draw.bit_generator.state, agent._constant_prompt[slot] = random, told
        chosen = choose(decisions, slots)
        if chosen[0].answers:
            heard.append((chosen[0], without[0]))
        return chosen

    agent.choose = listen  # type: ignore[method-assign]
    return heard


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        (Chosen(99), "agent lgx chose number 99 of 4 candidates"),
        (Chosen(-1), "agent lgx chose number -1 of 4 candidates"),
        (Chosen(0, scores=(0.5,)), "agent lgx gives 1 scores for 4 options"),
    ],
)
def test_a_choice_that_is_none_is_told(chosen: Chosen, message: str) -> None:
    agent, env = built("lgx")
    agent.choose = lambda decisions, slots: [chosen]  # type: ignore[attr-defined]
    with pytest.raises(ConfigError, match=message.replace(" 4 ", r" \d+ ")):
        play(agent, env, episodes(1)[0], 20)
