"""PPO's loss of chunks of whole episodes."""

from __future__ import annotations

import torch
from tensordict import TensorDict
from torch import Tensor

from ucon.learning.episodes.experience import ADVANTAGE, LOG_P, TARGET
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.policies.sequences import Batch, Chunk
from ucon.learning.ppo.clipped_loss import LOGGED, PPOLoss
from ucon.learning.run.protocol import Figures

_FIGURES = ("loss", *LOGGED, "kl")


class EpisodeLoss:
    """Clipped objective, squared error of the value and an entropy bonus, over whole episodes.

    The loss of a batch is the mean over its steps; a chunk's share is its mean times its share of the steps.

    Args:
        temperature: at which actions were drawn.
        clip: largest change of an action's probability ratio from 1.
        entropy: weight of the entropy bonus.
        value: weight of the value's loss.

    Raises:
        ConfigError: a number out of range.
    """

    n_sums = len(_FIGURES) + 1
    discount = 1.0
    """Discount of the returns in chunks. They are not read: value targets come with the experience."""

    def __init__(
        self, temperature: float = 1.0, clip: float = 0.2, entropy: float = 0.003, value: float = 0.01
    ) -> None:
        self._loss, self._temperature = PPOLoss(clip, entropy, value), temperature

    def scale(self, batch: Batch) -> float:
        """Number of steps of a batch, by which its loss is divided."""
        return float(sum(batch.lengths))

    def __call__(self, outputs: PolicyOutputs, chunk: Chunk, scale: float) -> tuple[Tensor, Tensor]:
        """A chunk's share of the batch's loss.

        Args:
            outputs: logits (T, B, 7) and values (T, B) of the chunk.
            chunk: actions as labels, masks, and the experience among the frames, (T, B).
            scale: number of steps of the whole batch, by :meth:`scale`.

        Returns:
            The loss, a scalar float32, and the sums that :meth:`figures` reads, (n_sums,) float64 on the CPU.
        """
        there = chunk.present
        steps = int(there.sum())
        played = {"action": chunk.labels[there], "action_log_prob": chunk.frames[LOG_P][there]}
        played |= {"advantage": chunk.frames[ADVANTAGE][there][:, None]}
        played |= {"value_target": chunk.frames[TARGET][there][:, None]}
        logits = outputs.logits.float()[there] / self._temperature
        loss, figures = self._loss(TensorDict(played, [steps]), logits, outputs.value.float()[there])
        told = {"loss": float(loss.detach()), **figures}
        sums = torch.tensor([*(told[name] * steps for name in _FIGURES), float(steps)], dtype=torch.float64)
        return loss * (steps / scale), sums

    def figures(self, sums: Tensor) -> Figures:
        """Means to log, from sums over whole batches, (n_sums,): the loss and its parts, and ``kl``."""
        *totals, steps = sums.tolist()
        return {name: total / max(steps, 1.0) for name, total in zip(_FIGURES, totals, strict=True)}
