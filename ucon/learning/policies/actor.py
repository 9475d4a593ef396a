"""A policy as a module over tensordicts, which is what TorchRL's collectors call."""

from __future__ import annotations

from typing import Any, cast

import torch
from tensordict import TensorDictBase
from tensordict.nn import ProbabilisticTensorDictModule, ProbabilisticTensorDictSequential, TensorDictModuleBase
from torch import nn
from torch.distributions import Categorical

from ucon.core.errors import DataError
from ucon.learning.policies.action_policy import ActionPolicy
from ucon.learning.ppo.rollout_env import STATE


class StepActor(TensorDictModuleBase):
    """Reads ``frames``, ``context`` and recurrent ``state`` of one step; writes logits, value and the next state.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module.
    """

    def __init__(self, policy: nn.Module) -> None:
        super().__init__()
        self.policy: Any = policy
        self.names = tuple(cast(ActionPolicy, policy).initial_state(1))
        self.in_keys = ["frames", "context", *((STATE, name) for name in self.names)]
        self.out_keys = ["logits", "state_value", *(("next", STATE, name) for name in self.names)]

    def forward(self, tensordict: TensorDictBase) -> TensorDictBase:
        """One step of one environment; tensors have no batch axis.

        Args:
            tensordict: has ``frames``, ``context`` and ``state`` by name, (...).

        Returns:
            The same tensordict with ``logits`` (A,) float32, ``state_value`` (1,) float32 and the next ``state``.

        Raises:
            DataError: the recurrent state is missing.
        """
        frames = {name: tensor[None, None] for name, tensor in tensordict["frames"].items()}  # (1, 1, ...)
        context = {name: tensor[None] for name, tensor in tensordict["context"].items()}
        state = {name: self._state(tensordict, name)[None] for name in self.names}
        outputs = self.policy(frames, context, state)
        tensordict["logits"] = outputs.logits[0, 0].float()
        tensordict["state_value"] = outputs.value[0].float()  # (1,)
        for name in self.names:
            tensordict["next", STATE, name] = outputs.state[name][0]
        return tensordict

    @staticmethod
    def _state(tensordict: TensorDictBase, name: str) -> torch.Tensor:
        found: torch.Tensor | None = tensordict.get((STATE, name), None)
        if found is None:
            raise DataError(
                f"no recurrent state '{name}' in the played steps; add a TensorDictPrimer to the environment"
            )
        return found


def sampling() -> ProbabilisticTensorDictModule:
    """Module that draws ``action`` from ``logits`` and adds its log-probability; a logit of -inf is never drawn."""
    return ProbabilisticTensorDictModule(
        in_keys=["logits"],
        out_keys=["action"],
        distribution_class=Categorical,
        distribution_kwargs={"validate_args": False},
        return_log_prob=True,
    )


def rollout_actor(policy: nn.Module) -> ProbabilisticTensorDictSequential:
    """The policy followed by :func:`sampling`: what a collector plays.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module.
    """
    return ProbabilisticTensorDictSequential(StepActor(policy), sampling())
