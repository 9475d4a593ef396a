"""A PPO collection, ready for updates: advantages, and sequences with the recurrent states from when they were played.

A policy with memory is trained on sequences that end where their episode or ``chunk`` ends; one without, on single
steps. Advantages are generalised (Schulman et al., 2016). The last step of each environment is not trained on: its
value stands for the return that the episode cut off there would still have had.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from tensordict import TensorDict, TensorDictBase
from torch import Tensor
from torchrl.objectives.value import GAE

from ucon.learning.ppo.rollout_env import OUTCOME, STATE
from ucon.learning.run.protocol import Figures


@dataclass(frozen=True)
class Sequences:
    """B sequences of up to T steps."""

    frames: dict[str, Tensor]
    """Tensors (T, B, ...); past a sequence's end its last frame is repeated."""
    context: dict[str, Tensor]
    """Tensors (B, ...), of each sequence's episode."""
    state: dict[str, Tensor]
    """Recurrent state before the first step, as it was when played; tensors (B, ...)."""
    there: Tensor
    """(T, B) bool, False past the end of a sequence."""
    played: TensorDictBase
    """(n,) the steps where ``there`` holds: ``action``, ``action_log_prob``, ``advantage`` and ``value_target``."""


class Experience:
    """One collection with its advantages and value targets.

    Args:
        batch: (rows, steps + 1) as a collector gives it.
        discount: of rewards, per step.
        trace: lambda of the generalised advantages.
        chunk: longest sequence in steps; 1 for a policy without memory.
    """

    def __init__(self, batch: TensorDictBase, discount: float, trace: float, chunk: int) -> None:
        self._batch, self._chunk = batch, chunk
        learned = TensorDict(
            {
                "state_value": batch["state_value"][:, :-1],
                "next": {
                    "state_value": batch["state_value"][:, 1:],
                    "reward": batch["next", "reward"][:, :-1],
                    "done": batch["next", "done"][:, :-1],
                    "terminated": batch["next", "terminated"][:, :-1],
                },
            },
            [batch.shape[0], batch.shape[1] - 1],
        )
        # average_gae: advantages of the whole collection are normalised to mean 0 and standard deviation 1
        learned = GAE(gamma=discount, lmbda=trace, value_network=None, average_gae=True)(learned)
        self.advantage, self.target = learned["advantage"], learned["value_target"]  # (rows, steps, 1)
        self._old = learned["state_value"]
        self.sequences = self._cut(batch["is_init"][:, :-1, 0].numpy())

    def __len__(self) -> int:
        """Number of steps that are trained on."""
        return self.advantage.numel()

    def _cut(self, begins: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Row, first step and length of each sequence, (n, 3) int64.

        Args:
            begins: (rows, steps) bool, True at an episode's first step.
        """
        found = []
        for row, first in enumerate(begins):
            starts = np.append(np.flatnonzero(first), len(first))
            starts = starts if starts[0] == 0 else np.insert(starts, 0, 0)
            for at, end in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
                found += [(row, k, min(self._chunk, end - k)) for k in range(at, end, self._chunk)]
        return np.array(found, np.int64)

    def minibatches(self, steps: int, draw: np.random.Generator) -> Iterator[Sequences]:
        """All sequences once, in random order, in minibatches of about ``steps`` steps.

        Args:
            steps: environment steps of a minibatch.
            draw: decides the order.
        """
        order = self.sequences[draw.permutation(len(self.sequences))]
        for part in np.array_split(order, max(1, round(len(self) / steps))):
            if len(part):
                yield self.taken(part)

    def frame_batches(self, steps: int) -> Iterator[dict[str, Tensor]]:
        """All frames that are trained on, in pieces (n, ...) of at most ``steps`` steps."""
        for row in range(len(self.advantage)):
            for at in range(0, self.advantage.shape[1], steps):
                piece = slice(at, min(at + steps, self.advantage.shape[1]))
                yield {name: tensor[row, piece] for name, tensor in self._batch["frames"].items()}

    def taken(self, part: NDArray[np.int64]) -> Sequences:
        """Gather sequences into padded tensors.

        Args:
            part: (B, 3) int64, rows of :attr:`sequences`.
        """
        row, first, length = (torch.from_numpy(column) for column in part.T.copy())
        steps = torch.arange(int(length.max()))[:, None]  # (T, 1)
        there = steps < length  # (T, B)
        time = first + torch.minimum(steps, length - 1)
        batch, rows = self._batch, row.expand_as(time)
        memory: TensorDictBase = batch.get(STATE, TensorDict({}))
        kept = rows[there], time[there]
        played = {name: batch[name][kept] for name in ("action", "action_log_prob")}
        played |= {"advantage": self.advantage[kept], "value_target": self.target[kept]}
        return Sequences(
            {name: tensor[rows, time] for name, tensor in batch["frames"].items()},
            {name: tensor[row, first] for name, tensor in batch["context"].items()},
            {name: tensor[row, first] for name, tensor in memory.items()},
            there,
            TensorDict(played, [len(kept[0])]),
        )

    def figures(self) -> Figures:
        """Figures of the collection, to log.

        ``episodes`` that ended; their mean ``success_rate``, ``spl``, ``steps`` and ``return``; and ``explained``, the
        share of the value targets' variance that the value had predicted.
        """
        over = self._batch["next", "done"][..., 0]
        outcome = self._batch["next", "outcome"][over].double()  # (episodes, 3)
        figures = {"episodes": float(len(outcome))}
        if len(outcome):
            mean = outcome.mean(0).tolist()
            figures |= dict(zip(("success_rate", *OUTCOME[1:]), mean, strict=True))
            figures["return"] = float(self._batch["next", "reward"].double().sum() / len(outcome))
        spread = self.target.double().var()
        if len(self) > 1 and float(spread) > 0:
            figures["explained"] = float(1 - (self.target.double() - self._old.double()).var() / spread)
        return figures
