"""Batches of whole episodes for networks with memory, cut into chunks through which gradients flow.

Episodes are sorted by length, so those that go on are the first of the batch: a chunk holds them alone, and the
recurrent state that they carry is cut to them. Nothing follows the end of an episode, so no state has to be reset.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from ucon.learning.imitation.trajectories import IGNORED, Replay, Trajectory, returns

if TYPE_CHECKING:
    from ucon.learning.policies.action_policy import ActionPolicy

Named = Mapping[str, Tensor]


@dataclass(frozen=True)
class Chunk:
    """T consecutive steps of the B episodes of a batch that are not over yet."""

    frames: Named
    """(T, B, ...), zeros after an episode's end."""
    context: Named
    """(B, ...)"""
    labels: Tensor
    """(T, B) int64, IGNORED where there is no label."""
    returns: Tensor
    """(T, B) float32"""
    present: Tensor
    """(T, B) bool: steps that were played."""
    changes: Tensor
    """(T, B) bool: the label is another action than the one before it."""


class Batch:
    """Whole episodes, the longest first.

    Args:
        episodes: what was done and is to be done, and what was seen.
        discount: of returns.
        device: where tensors are put.
    """

    def __init__(
        self, episodes: Sequence[tuple[Trajectory, Replay]], discount: float, device: torch.device | str
    ) -> None:
        chosen = sorted(episodes, key=lambda pair: -len(pair[1]))
        self.lengths = [len(replay) for _, replay in chosen]
        self.frames = [{n: torch.from_numpy(a).to(device) for n, a in replay.frames.items()} for _, replay in chosen]
        names = chosen[0][1].context
        self.context = {n: torch.from_numpy(np.stack([r.context[n] for _, r in chosen])).to(device) for n in names}
        self.labels = [torch.from_numpy(trajectory.classes).to(device) for trajectory, _ in chosen]
        self.changes = [torch.from_numpy(trajectory.changes).to(device) for trajectory, _ in chosen]
        self.returns = [torch.from_numpy(returns(replay.rewards, discount)).to(device) for _, replay in chosen]

    def augment(self, policy: ActionPolicy, seed: int) -> None:
        """Change the frames as the policy wants them for training; an episode's alike, from first to last."""
        for number, frames in enumerate(self.frames):
            generator = torch.Generator().manual_seed((seed + number) % (1 << 63))
            made = policy.augment({name: tensor[:, None] for name, tensor in frames.items()}, generator)
            self.frames[number] = {name: tensor[:, 0] for name, tensor in made.items()}

    def chunks(self, steps: int) -> Iterator[Chunk]:
        """The batch in pieces of ``steps`` steps; each holds the episodes that are longer than where it begins."""
        for begin in range(0, self.lengths[0], steps):
            n = sum(length > begin for length in self.lengths)
            piece = slice(begin, begin + steps)
            names = self.frames[0]
            frames = {name: pad_sequence([one[name][piece] for one in self.frames[:n]]) for name in names}
            labels = pad_sequence([one[piece] for one in self.labels[:n]], padding_value=IGNORED)
            present = pad_sequence([torch.ones_like(one[piece], dtype=torch.bool) for one in self.labels[:n]])
            values = pad_sequence([one[piece] for one in self.returns[:n]])
            changes = pad_sequence([one[piece] for one in self.changes[:n]])
            yield Chunk(frames, {name: t[:n] for name, t in self.context.items()}, labels, values, present, changes)


def cut(state: Named, episodes: int) -> dict[str, Tensor]:
    """The recurrent state of the first ``episodes`` of a batch, where gradients end."""
    return {name: tensor[:episodes].detach() for name, tensor in state.items()}
