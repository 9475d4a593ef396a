"""Adapts a network that scores views, such as the habit policy, to the interface of policies over actions.

Its actions are rows of the views that ``UcONSearch-v0`` offers; its frames are the tokens of one decision. It has no
recurrent state: what the agent remembers is in the tokens.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import torch
from torch import nn

from ucon.core.errors import ConfigError
from ucon.learning.policies.action_policy import Arrays, Choice, PolicyOutputs, Tensors
from ucon.search.text_tokens import TextTokens, name_table

#: Frames that are text embeddings. The encoder rounds them to float16, so float16 stores them without loss.
_EMBEDDED: Final = ("target", "habits")


class ViewPolicy(nn.Module):
    """An :class:`ucon.learning.policies.action_policy.ActionPolicy` for ``UcONSearch-v0``.

    Args:
        network: maps tokens to ``logits`` (B, V), -inf where there is no view, ``value`` (B,) and ``foresight``
            (B, V, R).
        text: embeds the names of categories; the same encoder as in the environment.
    """

    chooses: Choice = "actions"  # its actions are rows of views, so it is played like a policy over actions
    uses_habits = True

    def __init__(self, network: nn.Module, text: TextTokens | None = None) -> None:
        super().__init__()
        self.network = network
        self.register_buffer("names", torch.from_numpy(name_table((text or TextTokens()).encoder)), persistent=False)

    @property
    def architecture(self) -> str:
        """Architecture of the wrapped network, such as ``habit_policy``."""
        return str(self.network.architecture)

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Arguments of the wrapped network that its weights depend on."""
        found: Any = self.network.arguments
        return dict(found)

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """Empty: everything is in the observations."""
        return {}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """The observation's arrays by name, with text embeddings as float16.

        Raises:
            ConfigError: the observation is not one of ``UcONSearch-v0``.
        """
        if "views" not in observation:
            raise ConfigError(f"{self.architecture} chooses views: expected the environment UcONSearch-v0")
        return {
            name: np.asarray(array, np.float16) if name in _EMBEDDED else array for name, array in observation.items()
        }

    def features(self, frames: Tensors) -> Tensors:
        """The frames unchanged: no network is frozen."""
        return frames

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """The frames unchanged: there is no augmentation."""
        return frames

    def update_statistics(self, frames: Tensors) -> None:
        """Does nothing: there are no running statistics."""

    def initial_state(self, batch: int) -> Tensors:
        """Empty: there is no recurrent state."""
        return {}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Score the views of T decisions of B episodes; each decision by itself.

        Args:
            frames: observation tensors (T, B, ...) by name.
            context: empty.
            state: empty; returned as it is.

        Returns:
            Logits (T, B, V), -inf where there is no view, values (T, B) and foresight (T, B, V, R).
        """
        steps, batch = frames["ego"].shape[:2]
        tokens = {name: tensor.flatten(0, 1).float() for name, tensor in frames.items() if name != "thing_rows"}
        names: Any = self.names
        tokens["thing_names"] = names[frames["thing_rows"].flatten(0, 1).long()]  # row -1 is the last one: no category
        scores = self.network(tokens)
        logits, value, foresight = (found.unflatten(0, (steps, batch)) for found in scores)
        return PolicyOutputs(logits, value, state, foresight)
