"""Speed of environments and agents: steps per CPU second in one process on one core, through the Gymnasium API."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import gymnasium as gym
import numpy as np

import ucon.envs  # registers the environments
from ucon.core.progress import ticked
from ucon.core.rng import stream
from ucon.task.actions import Action
from ucon.task.agent import Agent
from ucon.task.episode import Episode

_STEPS = 600
#: Number of stages without an agent.
STAGES = 5
#: Probabilities of the actions of a random walk without Done, in the order of :class:`Action`; mostly MoveAhead.
WALK = (0.55, 0.15, 0.15, 0.06, 0.06, 0.03)

assert ucon.envs  # the import registers the environments


def bench_environment(
    episodes: Sequence[Episode],
    agent: Callable[[], Agent] | None = None,
    on_stage: Callable[[], None] = lambda: None,
) -> dict[str, float]:
    """The environment's figures of ``python -m ucon bench``.

    Args:
        episodes: one per scene is used. A figure is the median over them, ``..._worst`` the lowest.
        agent: for ``decisions_per_s``: steps per second of whole searches, with detector, map and choice.
        on_stage: called at the end of each of ``STAGES`` stages, and of the agent's stage.

    Returns:
        Figures by name, rounded to one decimal; for ``UcONSearch-v0`` a random choice counts as one decision.
    """
    chosen = one_per_home(episodes)
    figures: dict[str, float] = {}
    kinds = {"pixels": {"observe": "pixels"}, "symbolic": {"observe": "symbolic"}, "robot": {"task": "real_robot"}}
    for kind, options in kinds.items():
        rates = [walked_per_second(episode, options) for episode in ticked(f"steps, {kind}", chosen)]
        figures |= {f"env_{kind}_sps": median(rates), f"env_{kind}_sps_worst": min(rates)}
        on_stage()
    figures["env_with_resets_sps"] = _with_resets(chosen)
    on_stage()
    figures |= _choices(chosen)
    on_stage()
    if agent is not None:
        figures["decisions_per_s"] = _decisions(chosen, agent)
        on_stage()
    return {name: round(value, 1) for name, value in figures.items()}


def one_per_home(episodes: Sequence[Episode]) -> list[Episode]:
    """One episode of each of eight homes."""
    return list({episode.scene: episode for episode in episodes}.values())[:8]


def _make(episodes: Sequence[Episode], **options: Any) -> gym.Env[Any, Any]:
    return gym.make("UcON-v0", episodes=tuple(episodes), disable_env_checker=True, **options)


def walked_per_second(episode: Episode, options: dict[str, Any]) -> float:
    """Steps per CPU second of a random walk, without resets.

    Args:
        episode: the episode in which it walks.
        options: of ``UcON-v0``.
    """
    env = _make([episode], **options)
    actions = stream(0, "bench", episode.id).choice(len(WALK), size=_STEPS, p=WALK).tolist()
    env.reset(seed=0, options={"episode": 0})
    for action in (Action.ROTATE_LEFT,) * 4:  # warm up
        env.step(action)
    spent = 0.0
    for action in actions:
        started = time.process_time()
        truncated = env.step(action)[3]
        spent += time.process_time() - started
        if truncated:
            env.reset(options={"episode": 0})
    env.close()
    return _STEPS / max(spent, 1e-9)


def _with_resets(episodes: Sequence[Episode]) -> float:
    """Steps per CPU second with pixels over whole stored solutions, resets included."""
    env = _make(episodes)
    env.reset(seed=0, options={"episode": 0})
    steps = 0
    started = time.process_time()
    for _ in ticked("episodes with resets", range(3)):
        for index, episode in enumerate(episodes):
            env.reset(options={"episode": index})
            for digit in episode.solution:
                env.step(int(digit))
                steps += 1
    spent = time.process_time() - started
    env.close()
    return steps / max(spent, 1e-9)


def _decisions(episodes: Sequence[Episode], make_agent: Callable[[], Agent]) -> float:
    """Steps per CPU second of an agent's own searches, without environment resets."""
    agent = make_agent()
    env = _make(episodes, observe="symbolic", detector=True)
    decided, spent = 0, 0.0
    for index in ticked("an agent's searches", range(len(episodes))):
        obs, info = env.reset(seed=0, options={"episode": index})
        started = time.process_time()
        agent.reset([info])
        ended = False
        while not ended:
            obs, _, terminated, truncated, info = env.step(agent.act([obs], [info])[0])
            decided, ended = decided + 1, terminated or truncated
        spent += time.process_time() - started
    env.close()
    return decided / max(spent, 1e-9)


def _choices(episodes: Sequence[Episode]) -> dict[str, float]:
    """Random choices per CPU second in ``UcONSearch-v0``, and steps per choice."""
    rates, decided, walked = [], 0, 0
    for episode in ticked("choices", episodes):
        env = gym.make("UcONSearch-v0", episodes=(episode,), disable_env_checker=True)
        draw = stream(0, "bench", "search", episode.id)
        choices, spent, ended = 0, 0.0, False
        obs, _ = env.reset(seed=0, options={"episode": 0})
        while not ended:
            action = int(draw.choice(np.flatnonzero(obs["action_mask"])))
            started = time.process_time()
            obs, _, terminated, truncated, info = env.step(action)
            spent += time.process_time() - started
            choices, ended = choices + 1, terminated or truncated
        env.close()
        walked += info["episode_metrics"]["steps"]
        decided += choices
        rates.append(choices / max(spent, 1e-9))
    return {
        "search_decisions_per_s": median(rates),
        "search_decisions_per_s_worst": min(rates),
        "search_steps_per_decision": walked / decided,
    }
