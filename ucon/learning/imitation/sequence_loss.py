"""What is learned from steps of episodes: the labelled actions, and the return that follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import torch
from torch import Tensor
from torch.nn import functional

from ucon.core.errors import ConfigError, brief, unknown_name
from ucon.learning.imitation.trajectories import IGNORED
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.policies.sequences import Batch, Chunk
from ucon.learning.run.protocol import Figures
from ucon.task.actions import Action

_NAMES = tuple(action.name.lower() for action in Action)


@dataclass(frozen=True)
class SequenceLoss:
    """Cross-entropy of the labelled actions, rare ones and changes weighing more, and a Huber loss of the value.

    Raises:
        ConfigError: an unknown action, or a number that is none or out of range.
    """

    weights: Mapping[str, float] = field(default_factory=dict)
    """What a label weighs, by the action's name; 1 where it is not given. Done ends each episode."""
    change: float = 1.0
    """What a label weighs more where it is another action than the one before: seven labels in eight go straight on,
    and a policy that learned no more than that walks into a wall (inflection weighting, Wijmans et al. 2019)."""
    value: float = 0.05
    """Weight of the value's loss; 0 leaves it out."""
    discount: float = 0.99
    """Of the returns that the value is to tell."""

    n_sums = 6

    def __post_init__(self) -> None:
        if not isinstance(self.weights, Mapping):
            raise ConfigError(f"learner.loss.weights={brief(self.weights)}: expected action: weight, as {{done: 5}}")
        for name, weight in self.weights.items():
            if name not in _NAMES:
                raise ConfigError(unknown_name("action", str(name), _NAMES))
            _require(f"weights.{name}", weight, 1e6)
        _require("change", self.change, 1e6)
        _require("value", self.value, 1e6)
        _require("discount", self.discount, 1.0)

    def scale(self, batch: Batch) -> tuple[float, float]:
        """What sums over a batch are divided by: the weight of its labels, and its steps."""
        labels, changes = torch.cat(batch.labels).cpu(), torch.cat(batch.changes).cpu()
        return max(float(self._of(labels, changes).sum()), 1e-9), float(len(labels))

    def __call__(self, outputs: PolicyOutputs, chunk: Chunk, scale: tuple[float, float]) -> tuple[Tensor, Tensor]:
        """A chunk's share of the batch's loss, and the sums that :meth:`figures` reads, (n_sums,) float64."""
        logits, value = outputs.logits.float(), outputs.value.float()
        each = functional.cross_entropy(
            logits.flatten(0, 1), chunk.labels.flatten(), ignore_index=IGNORED, reduction="none"
        )
        weight = self._of(chunk.labels.flatten(), chunk.changes.flatten())
        told = (each * weight).sum()
        huber = functional.smooth_l1_loss(value, chunk.returns, reduction="none")
        worth = (huber * chunk.present).sum()
        right = (logits.argmax(-1) == chunk.labels).sum()
        known = (chunk.labels != IGNORED).sum()
        sums = torch.stack([told, weight.sum(), worth, chunk.present.sum(), right, known]).detach().double().cpu()
        return told / scale[0] + self.value * worth / scale[1], sums

    def figures(self, sums: Tensor) -> Figures:
        """What is logged of sums over whole batches."""
        told, weight, worth, present, right, known = sums.tolist()
        told, worth = told / max(weight, 1e-9), worth / max(present, 1.0)
        return {
            "loss": told + self.value * worth,
            "cross_entropy": told,
            "value_loss": worth,
            "accuracy": right / max(known, 1.0),
        }

    def _of(self, labels: Tensor, changes: Tensor) -> Tensor:
        """Weight of each label, float32; 0 of none."""
        table = torch.tensor([*(float(self.weights.get(name, 1.0)) for name in _NAMES), 0.0], device=labels.device)
        return table[torch.where(labels == IGNORED, len(_NAMES), labels)] * (1 + (self.change - 1) * changes)


def _require(name: str, value: object, most: float) -> None:
    if type(value) not in (int, float) or not 0 <= value <= most:  # type: ignore[operator]
        raise ConfigError(f"learner.loss.{name}={brief(value)}: must be from 0 to {most:g}")
