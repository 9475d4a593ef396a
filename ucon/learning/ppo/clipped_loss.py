"""The loss of proximal policy optimisation (Schulman et al., 2017) as TorchRL has it, of a policy's outputs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from tensordict import TensorDict, TensorDictBase
from tensordict.nn import ProbabilisticTensorDictSequential, TensorDictModule
from torch import Tensor, nn
from torchrl.objectives import ClipPPOLoss

from ucon.core.errors import ConfigError, brief
from ucon.learning.policies.actor import sampling

#: What is logged of a minibatch, by the name in TorchRL's result.
LOGGED = {
    "objective": "loss_objective",
    "value_loss": "loss_critic",
    "entropy": "entropy",
    "clipped": "clip_fraction",
}


class PPOLoss:
    """Clipped objective, squared error of the value (not clipped), and a bonus for entropy.

    Args:
        clip: how far the probability of an action may move in one step, as a ratio.
        entropy: weight of the bonus.
        value: weight of the value's loss.
        objective: weight of the clipped objective.

    Raises:
        ConfigError: a number out of range.
    """

    def __init__(self, clip: float = 0.2, entropy: float = 0.003, value: float = 0.5, objective: float = 1.0) -> None:
        named = {"clip": (clip, 1e-6), "entropy": (entropy, 0), "value": (value, 1e-6), "objective": (objective, 0)}
        for name, (number, least) in named.items():
            if type(number) not in (int, float) or not least <= number < 1e9:
                raise ConfigError(f"learner.loss.{name}={brief(number)}: must be a number from {least:g} up")
        # The network is run once for both, by who calls: TorchRL's parts only pass on what it said.
        said = TensorDictModule(nn.Identity(), in_keys=["new_logits"], out_keys=["logits"])
        worth = TensorDictModule(nn.Identity(), in_keys=["new_value"], out_keys=["state_value"])
        self.objective = objective
        self._loss: Any = ClipPPOLoss(
            ProbabilisticTensorDictSequential(said, sampling()),
            worth,
            clip_epsilon=clip,
            entropy_coeff=entropy,
            critic_coeff=value,
            loss_critic_type="l2",
            normalize_advantage=False,
            functional=False,
        )

    def __call__(self, played: TensorDictBase, logits: Tensor, value: Tensor) -> tuple[Tensor, Mapping[str, float]]:
        """The loss, a scalar, and figures.

        Args:
            played: (n,) ``action``, ``action_log_prob``, ``advantage`` (n, 1) and ``value_target`` (n, 1).
            logits: (n, A).
            value: (n,).
        """
        said = TensorDict({"new_logits": logits, "new_value": value[:, None]}, played.shape)
        found = self._loss(played.to(logits.device).update(said))
        loss = self.objective * found["loss_objective"] + found["loss_critic"] + found["loss_entropy"]
        figures = {name: float(found[key].detach()) for name, key in LOGGED.items()}
        return loss, figures | {"kl": self._kl(played, logits.detach())}

    @staticmethod
    def _kl(played: TensorDictBase, logits: Tensor) -> float:
        """How far the policy is from the one that played: r - 1 - log r, never negative (Schulman, 2020).

        TorchRL's estimate, -log r, has the same mean and far more noise.
        """
        now = logits.log_softmax(-1).gather(1, played["action"].to(logits.device)[:, None])[:, 0]
        log_ratio = now - played["action_log_prob"].to(logits.device)
        return float((log_ratio.exp() - 1 - log_ratio).mean())


def inference_mode_but_memory(policy: nn.Module) -> None:
    """No dropout while ratios of probabilities are compared; recurrent layers must be in training mode for cuDNN."""
    policy.eval()
    for module in policy.modules():
        if isinstance(module, nn.RNNBase) and not module.dropout:
            module.train()


def total(figures: list[Mapping[str, float]]) -> dict[str, float]:
    """Means of the figures of minibatches."""
    return {name: sum(one[name] for one in figures) / len(figures) for name in figures[0]}


def finite(tensor: Tensor) -> bool:
    """Whether all of it are numbers."""
    return bool(torch.isfinite(tensor).all())
