"""Speed of learning: frames and decisions that each learner plays, feeds and learns from in a second of wall time."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from statistics import median
from typing import Any, Final

from ucon.configuration.wiring import Factory
from ucon.programs.composing import train_config

#: What is measured: configuration of ``train.py``, small enough for some steps, and the option that sets the workers.
LEARNERS: Final[Mapping[str, tuple[tuple[str, ...], str]]] = {
    "imitation_frames_per_s": (
        ("agent=habit_policy_e2e", "learner=searches", "learner.batch=4", "learner.n_episodes=40"),
        "learner.workers",
    ),
    "dagger_frames_per_s": (
        (
            "agent=habit_policy_e2e", "learner=dagger", "learner.batch=4", "learner.n_episodes=40",
            "learner.rollouts.episodes=8", "learner.rollouts.per_iteration=2", "learner.rollouts.slots=8",
        ),
        "learner.workers",
    ),
    "ppo_frames_per_s": (("agent=habit_policy_e2e", "learner=ppo", "learner.frames=600"), "collector.workers"),
    "hybrid_ppo_decisions_per_s": (("agent=habit_policy", "learner=ppo", "learner.frames=600"), "collector.workers"),
}  # fmt: skip
FORESIGHT: Final = ("agent=habit_policy", "learner=foresight")
OF_FORESIGHT: Final = ("foresight_played_per_s", "foresight_decisions_per_s")
#: Steps that are measured, after one that is not.
STEPS: Final = 3
#: Searches that are played for foresight.
SEARCHES: Final = 40


def stages(workers: tuple[int, ...]) -> int:
    """How many measurements :func:`learning_rates` makes."""
    return (len(LEARNERS) + 1) * len(workers)


def learning_rates(workers: tuple[int, ...], measured: Callable[[], None]) -> dict[str, float]:
    """Frames or decisions a second of every learner, by name and number of worker processes.

    A learner's rate is the median over steps; a step plays, feeds and updates. Foresight plays first and learns then,
    and has a rate for each.

    Args:
        workers: numbers of processes that play, such as (1, 2).
        measured: called after every measurement.
    """
    found: dict[str, float] = {}
    for n in workers:
        for name, (words, option) in LEARNERS.items():
            with closing(Factory(train_config(*words, f"{option}={n}")["learner"])()) as learner:
                found[f"{name}_{n}"] = _rate(learner)
            measured()
        found |= {f"{name}_{n}": rate for name, rate in zip(OF_FORESIGHT, _foresight(n), strict=True)}
        measured()
    return found


def _rate(learner: Any) -> float:
    """Median frames a second of a learner whose figures count ``frames``."""
    frames, rates = learner.step()["frames"], []
    for _ in range(STEPS):
        began = time.perf_counter()
        so_far = learner.step()["frames"]
        rates.append((so_far - frames) / (time.perf_counter() - began))
        frames = so_far
    return float(median(rates))


def _foresight(workers: int) -> tuple[float, float]:
    """Decisions a second that are played and labelled, and that are learned from."""
    words = (*FORESIGHT, f"learner.workers={workers}", f"learner.n_searches={SEARCHES}")
    with _empty_cache(), closing(Factory(train_config(*words)["learner"])()) as learner:
        began = time.perf_counter()
        decisions = len(learner.decisions)
        played = decisions / (time.perf_counter() - began)
        learner.step()
        seconds = []
        for _ in range(STEPS):
            began = time.perf_counter()
            learner.step()
            seconds.append(time.perf_counter() - began)
    return played, float(learner.options.batch / median(seconds))


@contextmanager
def _empty_cache() -> Iterator[None]:
    """A cache of its own: what was played before would not be played again."""
    before = os.environ.get("UCON_CACHE")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["UCON_CACHE"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["UCON_CACHE"]
            else:
                os.environ["UCON_CACHE"] = before
