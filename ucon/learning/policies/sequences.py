"""Batches of whole episodes for networks with memory, cut into chunks through which gradients flow.

Episodes are sorted by length, longest first, so those still running are always the first rows of the batch. A chunk
holds only these rows, and the recurrent state is cut to them. No episode begins within a batch, so no state is reset.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from ucon.learning.imitation.trajectories import IGNORED, Replay, Trajectory, returns

if TYPE_CHECKING:
    from ucon.learning.policies.action_policy import ActionPolicy, PolicyOutputs
    from ucon.learning.run.protocol import Figures

Named = Mapping[str, Tensor]


@dataclass(frozen=True)
class Chunk:
    """T consecutive steps of those B episodes of a batch that are not over when the chunk begins."""

    frames: Named
    """(T, B, ...), zeros after an episode's end."""
    context: Named
    """(B, ...), the arrays of each episode."""
    labels: Tensor
    """(T, B) int64 action index, ``IGNORED`` where there is no label."""
    returns: Tensor
    """(T, B) float32 discounted return."""
    present: Tensor
    """(T, B) bool, True for steps that were played, False for padding."""
    changes: Tensor
    """(T, B) bool, True where the label differs from the action before it."""


class Batch:
    """Whole episodes as tensors, the longest first.

    Args:
        episodes: (trajectory, replay) pairs.
        discount: of returns, per step.
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
        """Replace the frames by the policy's augmentation of them; all steps of an episode are changed alike.

        Args:
            policy: its ``augment`` is called once per episode.
            seed: of the random changes; row k uses ``seed + k``.
        """
        for number, frames in enumerate(self.frames):
            generator = torch.Generator().manual_seed((seed + number) % (1 << 63))
            made = policy.augment({name: tensor[:, None] for name, tensor in frames.items()}, generator)
            self.frames[number] = {name: tensor[:, 0] for name, tensor in made.items()}

    def chunks(self, steps: int) -> Iterator[Chunk]:
        """The batch in chunks of up to ``steps`` steps, in order; each holds the episodes that reach its first step."""
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

    def mixed(self, steps: int, seed: int) -> Iterator[Chunk]:
        """The steps of all episodes in random order, up to ``steps`` at once: for policies without memory.

        Args:
            steps: largest number of rows of a chunk, which is one time step long.
            seed: of the order.
        """
        names, n = self.frames[0], len(self.lengths)
        device = self.labels[0].device
        frames = {name: torch.cat([one[name] for one in self.frames]) for name in names}
        labels, returned, changes = (torch.cat(parts) for parts in (self.labels, self.returns, self.changes))
        episode = torch.arange(n, device=device).repeat_interleave(torch.tensor(self.lengths, device=device))
        order = torch.randperm(len(labels), generator=torch.Generator().manual_seed(seed)).to(device)
        for some in order.split(steps):
            yield Chunk(
                {name: tensor[some][None] for name, tensor in frames.items()},
                {name: tensor[episode[some]] for name, tensor in self.context.items()},
                labels[some][None], returned[some][None],
                torch.ones(1, len(some), dtype=torch.bool, device=device), changes[some][None],
            )  # fmt: skip


class ChunkLoss(Protocol):
    """Loss of a batch of whole episodes, given chunk by chunk."""

    n_sums: int
    """Number of sums that figures are made of."""
    discount: float
    """Per step, of the returns in the chunks."""

    def scale(self, batch: Batch) -> Any:
        """Denominators of a batch's loss, for :meth:`__call__`."""
        ...

    def __call__(self, outputs: PolicyOutputs, chunk: Chunk, scale: Any) -> tuple[Tensor, Tensor]:
        """A chunk's share of the batch's loss, a scalar, and sums (n_sums,) float64 on the CPU for :meth:`figures`."""
        ...

    def figures(self, sums: Tensor) -> Figures:
        """Figures to log, ``loss`` among them, from sums over whole batches."""
        ...


def detached_state(state: Named, episodes: int) -> dict[str, Tensor]:
    """Recurrent state of the first ``episodes`` rows of a batch, detached: no gradient passes into the chunk before."""
    return {name: tensor[:episodes].detach() for name, tensor in state.items()}
