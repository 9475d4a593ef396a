"""Searching agents' decisions in words: they match what the agents do, however the agents are played."""

from __future__ import annotations

import json
import re
from functools import partial

import pytest

from models.agents.base import ControllerAgent
from models.agents.search import SearchController
from tests.models.playing import AGENTS, POLICIES, built, config_of, episodes, play
from ucon.configuration.wiring import Factory
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.perception.drawing.overlay import words
from ucon.task.actions import Action
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

DECIDING = [name for name in AGENTS if name not in (*POLICIES, "random")]
SEARCHING = ["belief_known_home", "frontier", "oracle_locations"]
_LOOK = re.compile(r"look at: (?P<name>[a-z ]+) (?P<track>\d+) \((on top|inside|under|beside)\)")
_OPEN = re.compile(r"open: (?P<name>[a-z ]+) (?P<track>\d+)")


def decided(name: str, episode: Episode) -> tuple[list[DecisionRecord], list[int]]:
    agent, env = built(name)
    actions = play(agent, env, episode)
    return agent.decisions(0), actions  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", DECIDING)
def test_whoever_decides_says_what_it_goes_for(name: str) -> None:
    (episode,) = episodes(1)
    made, actions = decided(name, episode)
    assert [d.number for d in made] == list(range(len(made)))
    assert {d.episode for d in made} == {episode.id}
    assert [d.step for d in made] == sorted(d.step for d in made)
    assert 0 <= made[0].step <= made[-1].step < len(actions)
    for decision in made:
        assert re.search("[a-z]", decision.words) or decision.asked, decision
        assert DecisionRecord.from_json(json.loads(decision.to_line())).words == decision.words


def test_an_agent_that_draws_decides_nothing() -> None:
    agent, env = built("random")
    play(agent, env, episodes(1)[0], 20)
    assert agent.decisions(0) == []  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", SEARCHING)
def test_a_search_ends_where_the_target_is_taken(name: str) -> None:
    ends = set()
    for episode in load_episodes("mini")[:4]:
        made, actions = decided(name, episode)
        taken = [d for d in made if d.kind == "target"]
        assert taken == made[len(made) - len(taken) :]
        if taken:
            assert [d.words for d in taken] == [f"take: {words(episode.target_category)}"]
        assert bool(taken) or len(actions) == 300
        ends.add(bool(taken))
    assert True in ends


@pytest.mark.parametrize("name", ["belief", "frontier"])
def test_what_it_says_is_what_it_does(name: str) -> None:
    """The opened thing is the one named, and the view it goes to shows the place that it names."""
    agent, env = built(name, "gt")
    assert isinstance(agent, ControllerAgent)
    looks = opens = 0
    for episode in episodes(3):
        obs, info = env.reset(options={"episode": episode})
        agent.reset([info])
        controller = agent.controllers[0]
        assert isinstance(controller, SearchController)
        search, ended, n = controller.searcher, False, 0
        while not ended:
            action = agent.act([obs], [info])[0]
            for decision in agent.decisions(0)[n:]:
                assert decision.step == search.map.step
                if look := _LOOK.fullmatch(decision.words):
                    track = int(look["track"])
                    assert words(search.map.category[track]) == look["name"]
                    assert search.choice is not None
                    assert search.map.gap_m(track, search.choice.view.xy) <= search.viewpoints.reach_m
                    looks += 1
                elif opened := _OPEN.fullmatch(decision.words):
                    track = int(opened["track"])
                    assert words(search.map.category[track]) == opened["name"]
                    assert track in search.containers.closed(search.map)
                    opens += 1
            n = len(agent.decisions(0))
            if action == Action.OPEN and not search.taking:
                last = agent.decisions(0)[-1]
                assert last.kind == "container", last
            obs, _, ended, truncated, info = env.step(action)
            ended = ended or truncated
    assert looks > 5
    assert opens > 5


def test_who_reads_says_what_it_believes() -> None:
    (episode,) = episodes(1)
    believed = [d.text for d in decided("belief", episode)[0] if d.kind == "landmark"]
    assert believed
    assert all(re.match(r"belief \d+\.\d%, worth ", text) for text in believed)
    assert not [d for d in decided("frontier", episode)[0] if "belief" in d.text]


@pytest.mark.parametrize("name", ["belief", "frontier_nearest", "habit_policy"])
def test_lines_are_the_same_bytes_for_any_number_of_workers(name: str) -> None:
    config = config_of(name, "habit_level=retrieval")
    chosen = load_episodes("mini")[::25]
    env = partial(UcONEnv, chosen[:1], observe="symbolic", detector=True, habit_level="retrieval")
    spec = RunSpec(Factory(config["agent"]), env, "retrieval")
    alone, apart = ([p.decisions for p in evaluate(spec, chosen, workers=n)] for n in (0, 2))
    assert [[d.to_line() for d in made] for made in alone] == [[d.to_line() for d in made] for made in apart]
    assert all(alone)
