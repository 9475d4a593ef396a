"""What was played, ready to learn from: advantages, and sequences that begin with the recurrent state of their time.

Whatever has a memory is learned from in sequences that end where their episode or ``chunk`` ends; what has none, step
by step. Advantages are generalised (Schulman et al., 2016). The last step of each environment is not learned from: its
value stands for what the episode that was cut off there would still have been worth.
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
    """Tensors (T, B, ...)."""
    context: dict[str, Tensor]
    """Tensors (B, ...)."""
    state: dict[str, Tensor]
    """Recurrent state before the first step, as it was when it was played; tensors (B, ...)."""
    there: Tensor
    """(T, B) bool: not past the end of a sequence."""
    played: TensorDictBase
    """(n,), the steps that are there: ``action``, ``action_log_prob``, ``advantage``, ``value_target``."""


class Experience:
    """One collection.

    Args:
        batch: (rows, steps + 1) as a collector gives it.
        discount: of rewards, a step.
        trace: of the advantages (lambda).
        chunk: steps of a sequence; 1 for what has no memory.
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
        # average_gae: advantages of the whole collection get mean 0 and deviation 1
        learned = GAE(gamma=discount, lmbda=trace, value_network=None, average_gae=True)(learned)
        self.advantage, self.target = learned["advantage"], learned["value_target"]  # (rows, steps, 1)
        self._old = learned["state_value"]
        self.sequences = self._cut(batch["is_init"][:, :-1, 0].numpy())

    def __len__(self) -> int:
        """Steps that are learned from."""
        return self.advantage.numel()

    def _cut(self, begins: NDArray[np.bool_]) -> NDArray[np.int64]:
        """(n, 3) row, first step and length of each sequence; ``begins`` (rows, steps) where an episode does."""
        found = []
        for row, first in enumerate(begins):
            starts = np.append(np.flatnonzero(first), len(first))
            starts = starts if starts[0] == 0 else np.insert(starts, 0, 0)
            for at, end in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
                found += [(row, k, min(self._chunk, end - k)) for k in range(at, end, self._chunk)]
        return np.array(found, np.int64)

    def minibatches(self, steps: int, draw: np.random.Generator) -> Iterator[Sequences]:
        """All sequences once, in parts of about so many steps, in a drawn order."""
        order = self.sequences[draw.permutation(len(self.sequences))]
        for part in np.array_split(order, max(1, round(len(self) / steps))):
            if len(part):
                yield self.taken(part)

    def seen(self, steps: int) -> Iterator[dict[str, Tensor]]:
        """All frames that are learned from, (n, ...), at most so many at a time."""
        for row in range(len(self.advantage)):
            for at in range(0, self.advantage.shape[1], steps):
                piece = slice(at, min(at + steps, self.advantage.shape[1]))
                yield {name: tensor[row, piece] for name, tensor in self._batch["frames"].items()}

    def taken(self, part: NDArray[np.int64]) -> Sequences:
        """The sequences in the rows of ``part``, (B, 3)."""
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
        """Of the episodes that ended, and how much of the returns the value had foreseen."""
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
