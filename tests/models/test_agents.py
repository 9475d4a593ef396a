from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "perception"))
from toy import ToyEnv, two_rooms  # (the path above)

from models.agents.belief import BeliefAgent
from models.agents.frontier import FrontierAgent
from models.agents.oracle import OracleAgent
from models.agents.oracle_locations import OracleLocationsAgent, true_locations
from models.agents.random import RandomAgent
from models.nets.belief.head_reader import HeadReader
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.habits import book
from ucon.perception.belief.from_habits import ReadHabits
from ucon.perception.belief.target_belief import Locations
from ucon.retrieval.context import ContextHabits
from ucon.task.agent import Agent
from ucon.task.sets import load_episodes

TARGETS = ("bowl", "pencil_box", "coffee_cup", "teapot")


def in_the_cupboard(info: object) -> Locations:
    p = np.zeros((2, 4))
    p[0, 1], p[1, 0] = 0.6, 0.3
    return Locations(("bottom_cabinet", "breakfast_table"), p)


def test_what_reads_for_it_is_told_in_the_fingerprint() -> None:
    reader = HeadReader.load()
    assert BeliefAgent(ReadHabits(reader)).fingerprint() == reader.fingerprint() != ""
    assert BeliefAgent().fingerprint() == BeliefAgent(in_the_cupboard).fingerprint() == ""


def play(agent: Agent, env: ToyEnv) -> tuple[bool, list[int]]:
    obs, info = env.reset()
    agent.reset([info])
    actions: list[int] = []
    while True:
        actions += agent.act([obs], [info])
        obs, _, done, truncated, info = env.step(actions[-1])
        if done or truncated:
            return info["success"], actions


SEARCHERS = {"frontier": FrontierAgent, "belief": lambda: BeliefAgent(in_the_cupboard)}


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("nav", [True, False], ids=["true", "observed"])
@pytest.mark.parametrize("name", SEARCHERS)
def test_searchers_find_everything(name: str, nav: bool, target: str) -> None:
    success, actions = play(SEARCHERS[name](), ToyEnv(two_rooms(), target, (12, 4, 1), nav=nav))
    assert success
    assert len(actions) < 120


@pytest.mark.parametrize("name", SEARCHERS)
def test_same_episode_same_actions(name: str) -> None:
    env = ToyEnv(two_rooms(), "teapot", (12, 4, 1))
    agent = SEARCHERS[name]()
    first = play(agent, env)
    play(agent, ToyEnv(two_rooms(), "bowl", (14, 4, 3)))
    assert play(agent, env) == first
    assert play(SEARCHERS[name](), env) == first


def test_good_belief_saves_steps() -> None:
    env = ToyEnv(two_rooms(), "coffee_cup", (12, 4, 1))
    _, by_belief = play(BeliefAgent(in_the_cupboard), env)
    _, by_coverage = play(FrontierAgent(), env)
    assert len(by_belief) <= len(by_coverage)


def test_a_batch_is_its_parts() -> None:
    envs = [ToyEnv(two_rooms(), target, (12, 4, 1)) for target in TARGETS[:2]]
    alone = [play(FrontierAgent(), env)[1] for env in envs]
    agent = FrontierAgent()
    frames = [env.reset() for env in envs]
    agent.reset([frames[1][1]], slots=[7])
    agent.reset([frames[0][1]], slots=[3])
    together: list[list[int]] = [[], []]
    for step in range(min(map(len, alone)) - 1):
        actions = agent.act([f[0] for f in frames], [f[1] for f in frames], slots=[3, 7])
        for k, env in enumerate(envs):
            together[k].append(actions[k])
            obs, _, _, _, info = env.step(actions[k])
            frames[k] = (obs, info)
        assert together == [a[: step + 1] for a in alone]


def test_random_depends_on_seed_and_episode_only() -> None:
    def draw(seed: int, episode: str, skip: int = 0) -> list[int]:
        agent = RandomAgent(seed)
        for k in range(skip):
            agent.reset([{"episode": f"other {k}"}])
            agent.act([{}], [{}])
        agent.reset([{"episode": episode}])
        return [agent.act([{}], [{}])[0] for _ in range(200)]

    assert draw(0, "a") == draw(0, "a", skip=3)
    assert draw(0, "a") != draw(0, "b")
    assert draw(0, "a") != draw(1, "a")
    assert set(draw(0, "a")) >= set(range(6))


def test_oracle_replays_and_says_what_it_needs() -> None:
    agent = OracleAgent()
    agent.reset([{"privileged": {"solution": "0126"}}])
    assert [agent.act([{}], [{}])[0] for _ in range(5)] == [0, 1, 2, 6, 6]
    with pytest.raises(ConfigError, match="privileged=True"):
        agent.reset([{"target": "bowl"}])


def test_oracle_locations_knows_the_places_and_no_more() -> None:
    """The drawn place is among them; without privileged information it says what it needs."""
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level="none", privileged=True)
    for episode in load_episodes("mini")[:12]:
        _, info = env.reset(options={"episode": episode})
        places = info["privileged"]["locations"]
        assert sum(p for *_, p in places) == pytest.approx(1.0)
        entry, index = episode.placed_by[episode.target]
        drawn = book().entries[book().entry_number[entry]].placements[index]
        assert (drawn.relation, drawn.anchor) in {(relation, anchor) for relation, anchor, _ in places}
        known = true_locations(info)
        assert known.p.sum() == pytest.approx(1.0)
    with pytest.raises(ConfigError, match="privileged=True"):
        OracleLocationsAgent().reset([{"target": "mug"}])


def test_belief_at_context_tells_what_it_saw_and_reads_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """It reports only what it has detected, and acts the same without the target until it would see it."""
    told: list[tuple[set[str], dict[str, float]]] = []
    lists: list[tuple[str, ...]] = []
    update = ContextHabits.update

    def heard(self: ContextHabits, seen: set[str], emptied: dict[str, float]) -> bool:
        told.append((set(seen), dict(emptied)))
        changed = update(self, seen, emptied)
        lists.append(self.texts)
        return changed

    monkeypatch.setattr(ContextHabits, "update", heard)
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level="context")
    actions = []
    for episode in sorted(load_episodes("mini"), key=lambda e: -e.shortest_path_m)[:2]:
        objects = list(episode.arrangement.objects)
        objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
        gone = replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))
        for version in (episode, gone):
            agent, detected = BeliefAgent(), set()
            obs, info = env.reset(options={"episode": version})
            agent.reset([info])
            actions.append([])
            for _ in range(40):
                if env.search.counts[env.search.target]:
                    break
                detected |= set(info["detections"].category)
                actions[-1] += agent.act([obs], [info])
                if told:
                    assert told[-1][0] <= detected
                    assert told[-1][1].keys() <= told[-1][0]
                obs, _, done, _, info = env.step(actions[-1][-1])
                assert not done
            told.clear()
        n = len(actions[-2])
        assert n > 3
        assert actions[-1][:n] == actions[-2]
    assert len(set(lists)) > 4
