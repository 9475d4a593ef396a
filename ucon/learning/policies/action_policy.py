"""Interface of policies over the seven actions: arrays in, logits and a value out.

A policy turns an episode's ``info`` into arrays of fixed shape once (:meth:`ActionPolicy.context`) and each observation
once a step (:meth:`ActionPolicy.frame`); demonstrations store these arrays. All memory is in the recurrent state, which
the caller holds: it passes the state back at the next step, and a fresh one at each reset.

Frames pass through these stages; a policy that does not need one returns its input:
``frame`` (arrays of one step, on the CPU) -> ``features`` (outputs of frozen networks, computed once and stored) ->
``augment`` (random changes in training) -> the policy itself.
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
"""What a policy chooses from: the seven actions, or the views (goals to walk to) that ``UcONSearch-v0`` offers."""

#: Logits are rounded to multiples of this: their last bits depend on what else is in the batch.
_STEP: Final = 1e-4


class PolicyOutputs(NamedTuple):
    """Outputs for T steps of B episodes."""

    logits: Tensor
    """(T, B, 7) float32, one logit per action."""
    value: Tensor
    """(T, B) float32, estimated return."""
    state: Tensors
    """Recurrent state after the last step; tensors (B, ...)."""
    foresight: Tensor | None = None
    """(T, B, V, R), what is foreseen beyond each of V views; only of policies over views."""
    views: Tensor | None = None
    """(T, B) divergence, in nats, of the policy's goals from an expert's scores of views, where frames have these."""


def scores_views(policy: Any) -> bool:
    """True if a network scores the views of ``UcONSearch-v0``; False if it chooses among the seven actions."""
    kind: Choice = policy.chooses
    return kind == "views"


class ActionPolicy(Protocol):
    """A torch module that chooses among the seven actions.

    ``models.nets.policy_defaults`` has defaults of its methods.
    """

    architecture: str
    """Name of the network, also in tables.

    Weights fit one architecture only (:mod:`ucon.learning.run.network_files`).
    """
    chooses: Choice
    uses_habits: bool
    """Whether its outputs depend on the habit level."""
    learns_views: bool
    """Whether it learns from an expert's scores of views, which are ``views`` among the frames.

    See :data:`ucon.learning.imitation.view_labels.Label`.
    """

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Plain values that fix the version of the architecture: sizes, and hashes of frozen networks."""
        ...

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """Arrays that stay the same for an episode.

        Args:
            info: of the environment's reset.

        Returns:
            Arrays (...) by name, with the same shapes for every episode.
        """
        ...

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Arrays of one step; they depend on nothing that was seen before.

        Args:
            observation: of the environment's reset or last step.
            info: of the same.

        Returns:
            Arrays (...) by name, with the same shapes at every step.
        """
        ...

    def features(self, frames: Tensors) -> Tensors:
        """Outputs of the policy's frozen networks on frames, without gradients.

        Calling the policy with frames or with their features gives the same. Features of features are unchanged, and so
        are frames where no network is frozen.

        Args:
            frames: tensors (..., *shape) by name.

        Returns:
            Tensors (..., *shape) by name; inputs that only the frozen networks read are left out.
        """
        ...

    def augment(self, frames: Tensors, generator: Generator) -> Tensors:
        """Frames with random changes for training; the T steps of an episode are changed alike.

        Args:
            frames: tensors (T, B, ...) by name, or their features.
            generator: of the CPU.

        Returns:
            Tensors of the same shapes; ``frames`` itself where the policy asks for no augmentation.
        """
        ...

    def update_statistics(self, frames: Tensors) -> None:
        """Update statistics that are no parameters, such as running means, from frames (N, ...).

        Called between steps only: by imitation before it learns from a batch, by PPO after it learned from a
        collection.
        """
        ...

    def initial_state(self, batch: int) -> Tensors:
        """Recurrent state at the start of ``batch`` episodes: tensors (B, ...) by name.

        Empty for a policy without memory.
        """
        ...

    def __call__(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes.

        Args:
            frames: (T, B, ...) by name.
            context: (B, ...) by name.
            state: recurrent state before the first step, (B, ...) by name.
        """
        ...


def tensors_of(arrays: Arrays, device: device | str = "cpu") -> dict[str, Tensor]:
    """Copy arrays to a device.

    Args:
        arrays: NumPy arrays by name.
        device: where the tensors are put.

    Returns:
        Tensors with the same names, shapes and dtypes.
    """
    import torch

    return {name: torch.tensor(np.asarray(array)).to(device) for name, array in arrays.items()}


def stacked(parts: Sequence[Tensors]) -> dict[str, Tensor]:
    """Stack B mappings of tensors (...) into one mapping of tensors (B, ...); all have the same names and shapes."""
    import torch

    return {name: torch.stack([part[name] for part in parts]) for name in parts[0]}


def rounded_logits(logits: Tensor) -> NDArray[np.float64]:
    """Logits on the CPU, rounded to 1e-4, so that the choice does not depend on the rest of the batch.

    Args:
        logits: any shape.

    Returns:
        The same shape, float64.
    """
    found: NDArray[np.float64] = logits.double().cpu().numpy()
    return np.rint(found / _STEP) * _STEP
