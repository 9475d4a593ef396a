"""What policies over the seven actions have in common: defaults of their protocol (``ActionPolicy``)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.learning.policies.action_policy import Arrays, Choice, PolicyOutputs, Tensors

N_ACTIONS = 7


class PolicyModule(nn.Module):
    """A network that reads no habits, has nothing frozen and asks for no augmentation, until a subclass says else.

    Frozen networks are no submodules of it: parameters, gradients and saved weights are those that are learned.
    """

    architecture = ""
    chooses: Choice = "actions"
    uses_habits = False
    max_habits: int | None = None
    """Of one that reads habits, the longest list of them that it may have learned from; learners set it."""

    @property
    def arguments(self) -> Mapping[str, Any]:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return {}

    @property
    def device(self) -> torch.device:
        """Where its weights are."""
        return next(self.parameters()).device

    def check(self) -> None:
        """Fail in one line where frozen weights that it names are missing; reads none."""

    def fingerprint(self) -> str | None:
        """Hash of its frozen weights: "" without any, None where they are missing."""
        return ""

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        raise NotImplementedError

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        raise NotImplementedError

    def features(self, frames: Tensors) -> Tensors:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return frames

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return frames

    def picture(
        self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors
    ) -> NDArray[np.uint8] | None:
        """For videos: what it thinks at one step of one episode, (384, W, 3); None where it shows nothing.

        Args:
            info: of the episode's reset.
            frames: of that step, (1, 1, ...).
            context: (1, ...).
            state: before the step, (1, ...).
        """
        return None

    def update_statistics(self, frames: Tensors) -> None:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""

    def initial_state(self, batch: int) -> Tensors:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return {}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        raise NotImplementedError


def lstm_state(batch: int, lstm: nn.LSTM) -> dict[str, Tensor]:
    """Zeros (B, layers, hidden) of an LSTM, as :mod:`ucon.learning.policies.action_policy` carries them."""
    zeros = torch.zeros(batch, lstm.num_layers, lstm.hidden_size, device=next(lstm.parameters()).device)
    return {"hidden": zeros, "cell": zeros.clone()}


def run_lstm(lstm: nn.LSTM, inputs: Tensor, state: Tensors) -> tuple[Tensor, dict[str, Tensor]]:
    """T steps: ``inputs`` (T, B, in) and a state (B, layers, hidden) to outputs (T, B, hidden) and the state after.

    The state is float32 whatever autocast computes in. A processor without bfloat16 computes in float32: oneDNN has no
    such LSTM for it, and fails.
    """
    before = tuple(state[name].transpose(0, 1).contiguous() for name in ("hidden", "cell"))
    if inputs.device.type == "cpu" and not _has_bfloat16():
        with torch.autocast("cpu", enabled=False):
            outputs, after = lstm(inputs.float(), before)
    else:
        outputs, after = lstm(inputs, before)
    named = zip(("hidden", "cell"), after, strict=True)
    return outputs, {name: tensor.transpose(0, 1).float() for name, tensor in named}


@cache
def _has_bfloat16() -> bool:
    """Whether oneDNN computes in bfloat16 on this processor."""
    return torch.backends.mkldnn.is_available() and bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())
