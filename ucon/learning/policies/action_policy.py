"""What training and evaluation ask of a policy over the seven actions: arrays in, logits and a value out.

A policy turns what it is given into arrays of fixed shape once an episode (:meth:`ActionPolicy.context`) and once a
step (:meth:`ActionPolicy.frame`); demonstrations store these. All memory is in the recurrent state, which the caller
keeps: whoever plays, imitates or collects rollouts hands it back at the next step, and a fresh one at each reset.

The three stages from what is seen to what is learned from, each of which may be left out by who has no use for it:
``frame`` (arrays of one step, on the CPU) -> ``features`` (what frozen networks make of many frames, to be computed
once and stored) -> ``augment`` (changed at random for a step of training) -> the policy itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from torch import Generator, Tensor, device

Arrays = Mapping[str, NDArray[np.generic]]
Tensors = Mapping[str, "Tensor"]
Choice = Literal["actions", "views"]
"""What a policy chooses: one of the seven actions, or one of the views that ``UcONSearch-v0`` offers."""

#: Logits are compared in steps of this: their last bits depend on what is computed beside them.
_STEP: Final = 1e-4


class PolicyOutputs(NamedTuple):
    """Of T steps of B episodes."""

    logits: Tensor
    """(T, B, 7) float32, one for each action."""
    value: Tensor
    """(T, B) float32, the expected return."""
    state: Tensors
    """After the last step; tensors (B, ...)."""
    foresight: Tensor | None = None
    """(T, B, V), what a policy over views foretells of each; see :mod:`ucon.learning.ppo.foresight`."""


def scores_views(policy: Any) -> bool:
    """Whether a network scores the views that ``UcONSearch-v0`` offers; else it chooses among the seven actions."""
    kind: Choice = policy.chooses
    return kind == "views"


class ActionPolicy(Protocol):
    """A torch module with memory that chooses among the seven actions (``models.nets.policy_defaults``)."""

    architecture: str
    """Name of the network, in tables too; its weights fit no other (:mod:`ucon.learning.run.network_files`)."""
    chooses: Choice
    uses_habits: bool
    """Whether the habit level matters to it."""

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Plain values that say which version of the architecture this is, frozen networks by hash."""
        ...

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """What stays the same for an episode, from the ``info`` of its reset: arrays of the same shapes each time."""
        ...

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """What one step shows: arrays of the same shapes each time. Depends on nothing that was seen before."""
        ...

    def features(self, frames: Tensors) -> Tensors:
        """What the policy's frozen networks make of frames (..., *shape), without gradients; what they read is gone.

        Calling the policy with frames or with their features is the same. Features of features are themselves; so are
        frames where nothing is frozen.
        """
        ...

    def augment(self, frames: Tensors, generator: Generator) -> Tensors:
        """Frames (T, B, ...) as training may show them: changed at random, the T steps of an episode alike.

        ``generator`` is one of the CPU. Where a policy asks for no augmentation, frames come back as they are.
        """
        ...

    def update_statistics(self, frames: Tensors) -> None:
        """Frames (N, ...) that were seen while learning, for statistics that are no parameters.

        Called between steps alone: by imitation before a batch is learned from, by PPO after a collection was.
        """
        ...

    def initial_state(self, batch: int) -> Tensors:
        """The recurrent state at the start of ``batch`` episodes: tensors (B, ...); none of a policy without memory."""
        ...

    def __call__(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes: ``frames`` (T, B, ...), ``context`` (B, ...), ``state`` before the first step."""
        ...


def tensors_of(arrays: Arrays, device: device | str = "cpu") -> dict[str, Tensor]:
    """Copies of arrays on a device, same names, shapes and kinds of number."""
    import torch

    return {name: torch.tensor(np.asarray(array)).to(device) for name, array in arrays.items()}


def stacked(parts: Sequence[Tensors]) -> dict[str, Tensor]:
    """B mappings of tensors (...) to one of tensors (B, ...)."""
    import torch

    return {name: torch.stack([part[name] for part in parts]) for name in parts[0]}


def comparable(logits: Tensor) -> NDArray[np.float64]:
    """Logits of any shape on the CPU, rounded so that it does not matter what was computed beside them."""
    found: NDArray[np.float64] = logits.double().cpu().numpy()
    return np.rint(found / _STEP) * _STEP
