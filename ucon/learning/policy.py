"""What training and evaluation ask of a policy over the seven actions: arrays in, logits and a value out.

A policy turns what it is given into arrays of fixed shape once an episode (:meth:`ActionPolicy.context`) and once a
step (:meth:`ActionPolicy.frame`); demonstrations store these. All memory is in the recurrent state, which the caller
keeps: whoever plays, imitates or collects rollouts hands it back at the next step, and a fresh one at each reset.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from torch import Tensor

Arrays = Mapping[str, NDArray[np.generic]]
Tensors = Mapping[str, "Tensor"]


class Outputs(NamedTuple):
    """Of T steps of B episodes."""

    logits: Tensor
    """(T, B, 7) float32, one for each action."""
    value: Tensor
    """(T, B) float32, the expected return."""
    state: Tensors
    """After the last step; tensors (B, ...)."""


class ActionPolicy(Protocol):
    """A torch module with memory that chooses among the seven actions."""

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """What stays the same for an episode, from the ``info`` of its reset: arrays of the same shapes each time."""
        ...

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """What one step shows: arrays of the same shapes each time. Depends on nothing that was seen before."""
        ...

    def initial_state(self, batch: int) -> Tensors:
        """The recurrent state at the start of ``batch`` episodes: tensors (B, ...)."""
        ...

    def __call__(self, frames: Tensors, context: Tensors, state: Tensors) -> Outputs:
        """Read T steps of B episodes: ``frames`` (T, B, ...), ``context`` (B, ...), ``state`` before the first step."""
        ...
