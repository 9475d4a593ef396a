"""Speed of many homes at once: TorchRL against bare environments, one and two workers, larger images."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from statistics import median
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from tensordict import TensorDictBase
from torchrl.collectors import Collector, MultiAsyncCollector

from ucon.core.memory import keep_freed_memory
from ucon.core.progress import ticked
from ucon.core.rng import stream
from ucon.envs.batched import BatchedUcONEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.bench_env import WALK, one_per_home, walked_per_second
from ucon.task.episode import Episode

#: Environments in a batch, and steps of each environment in one batch of the collector.
SLOTS: Final = 64
_STEPS: Final = 15
#: Side of the larger images in pixels; the usual ones have 128.
LARGER_PX: Final = 224
#: Rounds, in which all variants are measured in turn, and batches per round: enough for every slot to end an episode.
_ROUNDS: Final = 5
_BATCHES: Final = 20
_ACTIONS: Final = 4001
_COLLECTOR: Final[dict[str, Any]] = {"compact_obs": True, "auto_register_policy_transforms": False}
STAGES: Final = 3


class Walk(torch.nn.Module):
    """Policy of random actions that were drawn beforehand, so that choosing costs nothing.

    Args:
        slots: number of environments in the batch.
    """

    def __init__(self, slots: int) -> None:
        super().__init__()
        self.actions = torch.from_numpy(walk(slots))
        self._taken = 0

    def forward(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Write the next ``action`` (N,) int64."""
        self._taken = (self._taken + 1) % len(self.actions)
        return tensordict.set("action", self.actions[self._taken])


def walk(slots: int) -> NDArray[np.int64]:
    """Random actions without Done, mostly moves, (n, slots) int64."""
    return stream(0, "bench", "batched").choice(len(WALK), size=(_ACTIONS, slots), p=WALK)


def bench_batched(episodes: Sequence[Episode], on_stage: Callable[[], None] = lambda: None) -> dict[str, float]:
    """The figures of ``python -m ucon bench --batched``.

    Args:
        episodes: one per scene is used, of eight scenes.
        on_stage: called at the end of each of ``STAGES`` stages.

    Returns:
        Figures by name. Rates without workers are per CPU second of one core, those with workers per second of wall
        time.
    """
    torch.set_num_threads(1)
    keep_freed_memory()
    chosen = one_per_home(episodes)
    found = overhead(chosen, SLOTS)
    on_stage()
    found |= scaling(chosen, SLOTS)
    on_stage()
    found["larger_images"] = median(_of_images(episode) for episode in ticked("larger images", chosen))
    on_stage()
    return {name: round(value, 3) for name, value in found.items()}


def overhead(episodes: Sequence[Episode], slots: int) -> dict[str, float]:
    """Steps per CPU second of a loop over environments, of a loop that keeps observations, and of TorchRL.

    All reset an environment after the 300 steps of its episode. TorchRL's collector stores every observation once
    (``compact_obs``), with rewards, end flags, trajectory numbers and actions.

    Args:
        episodes: episodes to draw from.
        slots: number of environments.
    """
    envs = [UcONEnv(episodes, planner="observed") for _ in range(slots)]
    for number, env in enumerate(envs):
        env.reset(seed=number)
    batches = iter(
        Collector(
            BatchedUcONEnv(slots, episodes),
            Walk(slots),
            frames_per_batch=slots * _STEPS,
            total_frames=-1,
            return_same_td=True,
            **_COLLECTOR,
        )
    )
    next(batches)
    kinds: dict[str, Callable[[], object]] = {
        "loop_sps": partial(_loop, envs, kept=None),
        "keeping_loop_sps": lambda: _loop(envs, kept=[]),
        "torchrl_sps": lambda: _take(batches, _BATCHES),
    }
    seconds: dict[str, list[float]] = {name: [] for name in kinds}
    for _ in ticked("TorchRL and loops", range(_ROUNDS)):
        for name, play in kinds.items():
            started = time.process_time()
            play()
            seconds[name].append(time.process_time() - started)
    steps = slots * _STEPS * _BATCHES
    rates = {name: steps / median(spent) for name, spent in seconds.items()}
    loop, keeping, ours = (seconds[name] for name in kinds)
    rates["torchrl_overhead"] = median(b / a - 1 for a, b in zip(loop, ours, strict=True))
    rates["torchrl_overhead_over_keeping"] = median(b / a - 1 for a, b in zip(keeping, ours, strict=True))
    return rates


def _loop(envs: Sequence[UcONEnv], kept: list[Any] | None) -> None:
    """Walk as many steps as the collector's batches have; ``kept`` collects observations, one batch at a time."""
    actions = walk(len(envs))
    for step in range(_STEPS * _BATCHES):
        for env, action in zip(envs, actions[step].tolist(), strict=True):
            seen = env.step(action)
            if kept is not None:
                kept.append(seen[0])
            if seen[2] or seen[3]:
                env.reset()
        if kept is not None and step % _STEPS == 0:
            kept.clear()


def _take(batches: Iterator[TensorDictBase], count: int) -> int:
    """Take batches; returns the number of their frames."""
    return sum(next(batches).numel() for _ in range(count))


def scaling(episodes: Sequence[Episode], slots: int) -> dict[str, float]:
    """Frames per second of wall time with one and with two worker processes, which do not wait for each other.

    Args:
        episodes: episodes to draw from.
        slots: environments of each worker.
    """
    rates: dict[int, list[float]] = {1: [], 2: []}
    for _ in ticked("worker processes", range(_ROUNDS)):
        for workers, found in rates.items():
            found.append(_with_workers(partial(_in_worker, slots, tuple(episodes)), slots, workers))
    medians = {f"workers_{workers}_fps": median(rate) for workers, rate in rates.items()}
    return medians | {"workers_gain": median(b / a for a, b in zip(rates[1], rates[2], strict=True))}


def _with_workers(make: Callable[[], BatchedUcONEnv], slots: int, workers: int) -> float:
    """Frames per second of all worker processes together."""
    collector = MultiAsyncCollector(
        [make] * workers, Walk(slots), frames_per_batch=slots * _STEPS, total_frames=-1, **_COLLECTOR
    )
    try:
        batches = iter(collector)
        _take(batches, 2 * workers)  # warm up: loads the homes and the renderer's code
        started = time.perf_counter()
        frames = _take(batches, _BATCHES * workers)
        return frames / (time.perf_counter() - started)
    finally:
        collector.shutdown()


def _in_worker(slots: int, episodes: tuple[Episode, ...]) -> BatchedUcONEnv:
    torch.set_num_threads(1)
    keep_freed_memory()
    return BatchedUcONEnv(slots, episodes)


def _of_images(episode: Episode) -> float:
    """Speed with larger images relative to the usual ones; each is the fastest of several walks, taken in turn."""
    size = {"width_px": LARGER_PX, "height_px": LARGER_PX}
    pairs = [(walked_per_second(episode, {}), walked_per_second(episode, size)) for _ in range(_ROUNDS)]
    usual, larger = map(max, zip(*pairs, strict=True))
    return larger / usual
