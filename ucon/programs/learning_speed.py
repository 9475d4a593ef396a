"""Speed of learning: frames or decisions per second of wall time that each learner plays, feeds and learns from."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from statistics import median
from typing import Any, Final

from ucon.configuration.wiring import Factory
from ucon.core.files import user_cache
from ucon.programs.composing import train_config

#: What is measured, by name: options of ``train.py`` for a few short steps, and the option that sets the workers.
LEARNERS: Final[Mapping[str, tuple[tuple[str, ...], str]]] = {
    "imitation_frames_per_s": (
        ("agent=habit_policy_e2e", "learner=searches", "learner.batch=4", "learner.n_episodes=40"),
        "learner.workers",
    ),
    "dagger_frames_per_s": (
        (
            "agent=habit_policy_e2e", "learner=dagger_searches", "learner.batch=4", "learner.n_episodes=40",
            "learner.rollouts.episodes=8", "learner.rollouts.per_iteration=2", "learner.rollouts.slots=8",
        ),
        "learner.workers",
    ),
    "ppo_frames_per_s": (("agent=habit_policy_e2e", "learner=ppo", "learner.frames=600"), "collector.workers"),
    "hybrid_ppo_decisions_per_s": (("agent=habit_policy", "learner=ppo", "learner.frames=600"), "collector.workers"),
}  # fmt: skip
#: Learners from kept decisions: how many searches are played for them, and the batches of one step.
FROM_DECISIONS: Final[Mapping[str, tuple[int, int]]] = {"foresight": (40, 1), "counterfactual": (16, 2)}
#: Options with which a learner from decisions learns everything from its first step on.
_AT_ONCE: Final[Mapping[str, tuple[str, ...]]] = {
    "counterfactual": ("learner.foresight_first=0", "learner.beyond_searches=8"),
}
#: What is measured of each: decisions that are played and labelled, and decisions that are learned from.
OF_DECISIONS: Final = ("labelled_per_s", "learned_per_s")
#: Steps that are measured, after one that is not.
STEPS: Final = 3


def stages(workers: tuple[int, ...]) -> int:
    """How many measurements :func:`learning_rates` makes."""
    return (len(LEARNERS) + len(FROM_DECISIONS)) * len(workers)


def learning_rates(workers: tuple[int, ...], measured: Callable[[], None]) -> dict[str, float]:
    """Frames or decisions a second of every learner, by name and number of worker processes.

    A learner's rate is the median over steps; a step plays, feeds and updates. Learners from kept decisions first play
    and then learn, and have a rate for each. Of the user's cache only homes and text are used.

    Args:
        workers: numbers of processes that play, such as (1, 2).
        measured: called after every measurement.
    """
    found: dict[str, float] = {}
    for n in workers:
        for name, (words, option) in LEARNERS.items():
            with _nothing_kept(), closing(Factory(train_config(*words, f"{option}={n}")["learner"])()) as learner:
                found[f"{name}_{n}"] = _rate(learner)
            measured()
        for name, (searches, batches) in FROM_DECISIONS.items():
            rates = zip(OF_DECISIONS, _from_decisions(name, searches, batches, n), strict=True)
            found |= {f"{name}_{what}_{n}": rate for what, rate in rates}
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


def _from_decisions(name: str, searches: int, batches: int, workers: int) -> tuple[float, float]:
    """Decisions a second that are played and labelled, and that are learned from."""
    sizes = (f"learner.workers={workers}", f"learner.n_searches={searches}", *_AT_ONCE.get(name, ()))
    with (
        _nothing_kept(),
        closing(Factory(train_config("agent=habit_policy", f"learner={name}", *sizes)["learner"])()) as learner,
    ):
        began = time.perf_counter()
        decisions = len(learner.decisions)
        labelled = decisions / (time.perf_counter() - began)
        learner.step()
        seconds = []
        for _ in range(STEPS):
            began = time.perf_counter()
            learner.step()
            seconds.append(time.perf_counter() - began)
    return labelled, float(batches * learner.options.batch / median(seconds))


@contextmanager
def _nothing_kept() -> Iterator[None]:
    """Context manager: a cache with homes and text alone, since what is in the cache is not played again."""
    before, kept = os.environ.get("UCON_CACHE"), user_cache()
    with tempfile.TemporaryDirectory() as folder:
        for name in ("homes", "text", "sha256"):
            if (kept / name).is_dir():
                (Path(folder) / name).symlink_to(kept / name)
        os.environ["UCON_CACHE"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["UCON_CACHE"]
            else:
                os.environ["UCON_CACHE"] = before
