"""The expert agrees with the stored shortest solutions, and finds its way from anywhere."""

from __future__ import annotations

import time

import pytest

from ucon.core.rng import stream
from ucon.envs.ucon_env import UcONEnv
from ucon.sim.render import RasterRenderer
from ucon.task.actions import Action
from ucon.task.expert import Expert
from ucon.task.rules import RULES
from ucon.task.sets import load_episodes

#: Probabilities of the actions in a random walk.
WALK = (0.45, 0.15, 0.15, 0.05, 0.05, 0.15)


def environment(task: str) -> UcONEnv:
    return UcONEnv("mini", task=task, habit_level="none", observe="symbolic")


def stray(env: UcONEnv, steps: int, seed: int) -> None:
    """Walk at random, opening every container on the way."""
    for action in stream(seed, "stray").choice(len(WALK), size=steps, p=WALK).tolist():
        env.step(action)
        if env.search.would_open():
            env.step(int(Action.OPEN))


def follow(env: UcONEnv, expert: Expert) -> tuple[int, int, bool]:
    """Follow the expert to the end; returns moves, steps and success."""
    moves = steps = 0
    ended = success = False
    while not ended:
        action = expert.action(env.search)
        assert action is not None
        _, _, ended, truncated, info = env.step(int(action))
        assert not truncated
        moves, steps = moves + (action == Action.MOVE_AHEAD), steps + 1
        success = ended and info["episode_metrics"]["success"]
    return moves, steps, success


@pytest.mark.parametrize("task", [name for name, rules in RULES.items() if not rules.continuous])
def test_takes_as_few_moves_as_the_stored_solution_and_no_more_steps(task: str) -> None:
    env, eyes, contained = environment(task), RasterRenderer(), 0
    for episode in env.episodes[::3]:
        env.reset(options={"episode": episode})
        expert = Expert(episode, eyes)
        found = expert.to_go(env.search)
        assert found is not None
        assert found[0] * 0.25 == episode.shortest_path_m, episode.id
        assert found[1] <= len(episode.solution), episode.id
        assert follow(env, expert) == (*found, True)
        contained += str(int(Action.OPEN)) in episode.solution
    assert contained >= 2, "none of them is behind a door"


def test_finds_its_way_after_straying_and_opening() -> None:
    env, eyes, opened = environment("paper"), RasterRenderer(), 0
    for number, episode in enumerate(env.episodes[::2]):
        env.reset(options={"episode": episode})
        expert = Expert(episode, eyes)
        stray(env, 60, number)
        opened += bool(env.search.opened.any())
        found = expert.to_go(env.search)
        assert found is not None, episode.id
        assert follow(env, expert) == (*found, True), episode.id
    assert opened >= 3


def test_says_what_is_right_in_every_step_of_a_stored_solution() -> None:
    """Along a shortest path, the rest never grows, and falls by one move with each move."""
    for episode in load_episodes("mini")[1::10]:
        env = environment("paper")
        env.reset(options={"episode": episode})
        expert = Expert(episode)
        for digit in episode.solution:
            before = expert.to_go(env.search)
            assert before is not None
            env.step(int(digit))
            after = expert.to_go(env.search)
            if int(digit) != Action.DONE:
                assert after is not None
                assert after[0] == before[0] - (int(digit) == Action.MOVE_AHEAD)


@pytest.mark.timed
def test_two_hundred_labels_a_second() -> None:
    env, labels = environment("paper"), 0
    expert = Expert(env.episodes[0])
    env.reset(options={"episode": env.episodes[0]})
    expert.action(env.search)  # compiles the kernels
    spent = 0.0
    for number, episode in enumerate(env.episodes[1:9]):
        env.reset(options={"episode": episode})
        started = time.process_time()
        expert = Expert(episode)
        spent += time.process_time() - started
        for action in stream(number, "walk").choice(len(WALK), size=50, p=WALK).tolist():
            started = time.process_time()
            expert.action(env.search)
            spent += time.process_time() - started
            labels += 1
            env.step(action)
    assert labels / spent >= 200
