"""Loss of a policy over the seven actions: cross-entropy of the labels and regression of the return."""

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

#: Denominators of the parts of a batch's loss.
Scale = tuple[float, float, float]
_NAMES = tuple(action.name.lower() for action in Action)


@dataclass(frozen=True)
class SequenceLoss:
    """Weighted cross-entropy of the labelled actions, plus a Huber loss of the value against the discounted return.

    The loss of a batch is sum(weight * cross-entropy) / sum(weight) + ``value`` * mean(Huber) + ``views`` *
    mean(divergence). A step without a label has weight 0 in the first term; the last mean is over the steps in which
    the expert scores views.

    Raises:
        ConfigError: an unknown action, or a number out of range.
    """

    weights: Mapping[str, float] = field(default_factory=dict)
    """Weight of a label by its action's name in lower case; 1 where not given.

    Done, for example, is one label per episode.
    """
    change: float = 1.0
    """Factor on the weight of a label that differs from the action before it: inflection weighting (Wijmans 2019).

    Seven labels in eight repeat "forward"; a policy that learned only that would walk into walls.
    """
    value: float = 0.05
    """Weight of the value's loss; 0 leaves it out."""
    discount: float = 0.99
    """Discount per step of the returns that the value is trained on."""
    views: float = 0.0
    """Weight of the mean divergence of the policy's goals from the expert's scores of views; 0 leaves it out."""

    n_sums = 8

    def __post_init__(self) -> None:
        if not isinstance(self.weights, Mapping):
            raise ConfigError(f"learner.loss.weights={brief(self.weights)}: expected action: weight, as {{done: 5}}")
        for name, weight in self.weights.items():
            if name not in _NAMES:
                raise ConfigError(unknown_name("action", str(name), _NAMES))
            _require(f"weights.{name}", weight, 1e6)
        _require("change", self.change, 1e6)
        _require("value", self.value, 1e6)
        _require("views", self.views, 1e6)
        _require("discount", self.discount, 1.0)

    def scale(self, batch: Batch) -> Scale:
        """Denominators of a batch's loss.

        Returns:
            Sum of its label weights (at least 1e-9), its number of steps, and how many of them have labels of views (at
            least 1).
        """
        labels, changes = torch.cat(batch.labels).cpu(), torch.cat(batch.changes).cpu()
        told = sum(float(_told(frames).sum()) for frames in batch.frames)
        return max(float(self._weights_of(labels, changes).sum()), 1e-9), float(len(labels)), max(told, 1.0)

    def __call__(self, outputs: PolicyOutputs, chunk: Chunk, scale: Scale) -> tuple[Tensor, Tensor]:
        """A chunk's share of the batch's loss.

        Args:
            outputs: logits (T, B, 7) and values (T, B) of the chunk.
            chunk: labels, returns and masks, (T, B).
            scale: denominators of the whole batch, by :meth:`scale`.

        Returns:
            The loss, a scalar float32, and the sums that :meth:`figures` reads, (n_sums,) float64 on the CPU.
        """
        logits, value = outputs.logits.float(), outputs.value.float()
        each = functional.cross_entropy(
            logits.flatten(0, 1), chunk.labels.flatten(), ignore_index=IGNORED, reduction="none"
        )
        weight = self._weights_of(chunk.labels.flatten(), chunk.changes.flatten())
        label_loss = (each * weight).sum()
        huber = functional.smooth_l1_loss(value, chunk.returns, reduction="none")
        value_loss = (huber * chunk.present).sum()
        views_loss = torch.zeros((), device=logits.device) if outputs.views is None else outputs.views.sum()
        correct = (logits.argmax(-1) == chunk.labels).sum()
        labelled = (chunk.labels != IGNORED).sum()
        sums = (
            torch.stack(
                [
                    *(label_loss, weight.sum(), value_loss, chunk.present.sum(), correct, labelled),
                    *(views_loss, _told(chunk.frames).sum()),
                ]
            )
            .detach()
            .double()
            .cpu()
        )
        loss = label_loss / scale[0] + self.value * value_loss / scale[1] + self.views * views_loss / scale[2]
        return loss, sums

    def figures(self, sums: Tensor) -> Figures:
        """Figures to log, from sums over whole batches.

        Args:
            sums: (n_sums,) as :meth:`__call__` returns them, added up.

        Returns:
            ``loss``, ``cross_entropy`` (nats), ``value_loss`` and ``accuracy`` (share of labelled steps); where the
            expert scores views, ``views_loss`` (nats).
        """
        label_loss, weight, value_loss, present, correct, labelled, views_loss, told = sums.tolist()
        label_loss, value_loss = label_loss / max(weight, 1e-9), value_loss / max(present, 1.0)
        views_loss /= max(told, 1.0)
        return {
            "loss": label_loss + self.value * value_loss + self.views * views_loss,
            "cross_entropy": label_loss,
            "value_loss": value_loss,
            "accuracy": correct / max(labelled, 1.0),
            **({"views_loss": views_loss} if told else {}),
        }

    def _weights_of(self, labels: Tensor, changes: Tensor) -> Tensor:
        """Weight of each label, (N,) float32; 0 where there is no label."""
        table = torch.tensor([*(float(self.weights.get(name, 1.0)) for name in _NAMES), 0.0], device=labels.device)
        return table[torch.where(labels == IGNORED, len(_NAMES), labels)] * (1 + (self.change - 1) * changes)


def _told(frames: Mapping[str, Tensor]) -> Tensor:
    """Steps (...) bool in which the expert scores views."""
    if "views" not in frames:
        return torch.zeros(1, dtype=torch.bool, device=next(iter(frames.values())).device)
    return frames["views"][..., 3].amax(-1) > 0


def _require(name: str, value: object, most: float) -> None:
    if type(value) not in (int, float) or not 0 <= value <= most:  # type: ignore[operator]
        raise ConfigError(f"learner.loss.{name}={brief(value)}: must be from 0 to {most:g}")
