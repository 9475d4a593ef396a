"""A network that scores views, such as the habit policy, as a policy that can be trained like those over the actions.

Its actions are the rows of ``UcONSearch-v0``'s views, its frames the tokens of one decision. It has no memory: what the
agent remembers is in the tokens.
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

#: Embeddings: the encoder rounds them to float16, so nothing is lost by storing them so.
_EMBEDDED: Final = ("target", "habits")


class ViewPolicy(nn.Module):
    """See the module. Implements :class:`ucon.learning.policies.action_policy.ActionPolicy` for ``UcONSearch-v0``.

    Args:
        network: tokens to ``logits`` (B, V), -inf where there is no view, ``value`` (B,) and ``foresight`` (B, V).
        text: embeds the names of things, as in the environment.
    """

    chooses: Choice = "actions"  # of the environment's rows: it is played like a policy over actions
    uses_habits = True

    def __init__(self, network: nn.Module, text: TextTokens | None = None) -> None:
        super().__init__()
        self.network = network
        self.register_buffer("names", torch.from_numpy(name_table((text or TextTokens()).encoder)), persistent=False)

    @property
    def architecture(self) -> str:
        """That of the network."""
        return str(self.network.architecture)

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Those of the network."""
        found: Any = self.network.arguments
        return dict(found)

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """Nothing: the environment's observations hold it."""
        return {}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """The observation.

        Raises:
            ConfigError: not one of ``UcONSearch-v0``.
        """
        if "views" not in observation:
            raise ConfigError(f"{self.architecture} chooses views: expected the environment UcONSearch-v0")
        return {
            name: np.asarray(array, np.float16) if name in _EMBEDDED else array for name, array in observation.items()
        }

    def features(self, frames: Tensors) -> Tensors:
        """Nothing is frozen."""
        return frames

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """Nothing is changed."""
        return frames

    def update_statistics(self, frames: Tensors) -> None:
        """It keeps no statistics."""

    def initial_state(self, batch: int) -> Tensors:
        """No memory."""
        return {}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Score T decisions of B episodes; each by itself. Logits (T, B, V)."""
        steps, batch = frames["ego"].shape[:2]
        tokens = {name: tensor.flatten(0, 1).float() for name, tensor in frames.items() if name != "thing_rows"}
        names: Any = self.names
        tokens["thing_names"] = names[frames["thing_rows"].flatten(0, 1).long()]  # row -1 is the last: none
        scores = self.network(tokens)
        logits, value, foresight = (found.unflatten(0, (steps, batch)) for found in scores)
        return PolicyOutputs(logits, value, state, foresight)
