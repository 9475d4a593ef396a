"""Defaults of the interface of policies over the seven actions (``ActionPolicy``)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.learning.policies.action_policy import Arrays, Choice, PolicyOutputs, Tensors
from ucon.search.thoughts import Thoughts

N_ACTIONS = 7


class PolicyModule(nn.Module):
    """Base of networks; by default one that reads no habits, has no frozen networks and asks for no augmentation.

    Frozen networks must not be submodules: parameters, gradients and stored weights are only those that are trained.
    """

    architecture = ""
    chooses: Choice = "actions"
    uses_habits = False
    learns_views = False
    max_habits: int | None = None
    """For a network that reads habits, the longest list of them in training; learners set it."""

    @property
    def arguments(self) -> Mapping[str, Any]:
        """No arguments; see :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return {}

    @property
    def device(self) -> torch.device:
        """Device of its parameters."""
        return next(self.parameters()).device

    def check(self) -> None:
        """Raise a one-line error where frozen weights that it needs are missing; loads none."""

    def fingerprint(self) -> str | None:
        """Hash of its frozen weights: "" if it has none, None where they are missing."""
        return ""

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """Arrays that stay the same for an episode; a subclass has to define them.

        See :class:`ucon.learning.policies.action_policy.ActionPolicy`.
        """
        raise NotImplementedError

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Arrays of one step; a subclass has to define them.

        See :class:`ucon.learning.policies.action_policy.ActionPolicy`.
        """
        raise NotImplementedError

    def features(self, frames: Tensors) -> Tensors:
        """The frames unchanged: no network is frozen."""
        return frames

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """The frames unchanged: no augmentation."""
        return frames

    def picture(
        self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors
    ) -> NDArray[np.uint8] | None:
        """For videos: a picture of one step of one episode.

        Args:
            info: of the episode's reset.
            frames: of that step, (1, 1, ...) by name.
            context: (1, ...) by name.
            state: recurrent state before the step, (1, ...) by name.

        Returns:
            (384, W, 3) uint8, or None where the policy draws nothing.
        """
        return None

    def thoughts(self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors) -> Thoughts | None:
        """For reports: what it thinks after one step of one episode; arguments as for :meth:`picture`.

        Returns:
            None where the policy keeps no belief.
        """
        return None

    def update_statistics(self, frames: Tensors) -> None:
        """Does nothing: there are no running statistics."""

    def initial_state(self, batch: int) -> Tensors:
        """Empty: there is no recurrent state."""
        return {}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes; a subclass has to implement it.

        See :class:`ucon.learning.policies.action_policy.ActionPolicy`.
        """
        raise NotImplementedError


def lstm_state(batch: int, lstm: nn.LSTM) -> dict[str, Tensor]:
    """Initial state of an LSTM: ``hidden`` and ``cell`` (B, layers, hidden) float32 of 0.

    Args:
        batch: B.
        lstm: gives the sizes and the device.
    """
    zeros = torch.zeros(batch, lstm.num_layers, lstm.hidden_size, device=next(lstm.parameters()).device)
    return {"hidden": zeros, "cell": zeros.clone()}


def run_lstm(lstm: nn.LSTM, inputs: Tensor, state: Tensors) -> tuple[Tensor, dict[str, Tensor]]:
    """Run an LSTM for T steps.

    The state is float32, whatever autocast computes in. On a processor without bfloat16 the LSTM runs in float32:
    oneDNN has no bfloat16 LSTM there and fails.

    Args:
        lstm: without ``batch_first``.
        inputs: (T, B, in).
        state: ``hidden`` and ``cell`` (B, layers, hidden).

    Returns:
        Outputs (T, B, hidden), and the state after the last step.
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
