"""Loss of proximal policy optimisation (Schulman et al., 2017), as TorchRL computes it, from a policy's outputs."""

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

#: Figures to log of a minibatch, and their names in TorchRL's result.
LOGGED = {
    "objective": "loss_objective",
    "value_loss": "loss_critic",
    "entropy": "entropy",
    "clipped": "clip_fraction",
}


class PPOLoss:
    """Clipped objective, squared error of the value (not clipped), and an entropy bonus.

    Args:
        clip: largest change of an action's probability ratio from 1.
        entropy: weight of the entropy bonus.
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
        # The caller runs the network once for both; these modules pass its outputs on to TorchRL.
        outputs = TensorDictModule(nn.Identity(), in_keys=["new_logits"], out_keys=["logits"])
        critic = TensorDictModule(nn.Identity(), in_keys=["new_value"], out_keys=["state_value"])
        self.objective = objective
        self._loss: Any = ClipPPOLoss(
            ProbabilisticTensorDictSequential(outputs, sampling()),
            critic,
            clip_epsilon=clip,
            entropy_coeff=entropy,
            critic_coeff=value,
            loss_critic_type="l2",
            normalize_advantage=False,
            functional=False,
        )

    def __call__(self, played: TensorDictBase, logits: Tensor, value: Tensor) -> tuple[Tensor, Mapping[str, float]]:
        """Loss of a minibatch of n steps.

        Args:
            played: (n,) with ``action`` (n,) int64, ``action_log_prob`` (n,), ``advantage`` (n, 1) and ``value_target``
                (n, 1).
            logits: (n, A) of the present policy.
            value: (n,) of the present policy.

        Returns:
            The loss, a scalar, and figures to log.
        """
        outputs = TensorDict({"new_logits": logits, "new_value": value[:, None]}, played.shape)
        found = self._loss(played.to(logits.device).update(outputs))
        loss = self.objective * found["loss_objective"] + found["loss_critic"] + found["loss_entropy"]
        figures = {name: float(found[key].detach()) for name, key in LOGGED.items()}
        return loss, figures | {"kl": self._kl(played, logits.detach())}

    @staticmethod
    def _kl(played: TensorDictBase, logits: Tensor) -> float:
        """Estimate of the KL divergence from the policy that played, in nats: mean of r - 1 - log r (Schulman, 2020).

        It is never negative. TorchRL's estimate, -log r, has the same expectation and far more noise.
        """
        now = logits.log_softmax(-1).gather(1, played["action"].to(logits.device)[:, None])[:, 0]
        log_ratio = now - played["action_log_prob"].to(logits.device)
        return float((log_ratio.exp() - 1 - log_ratio).mean())


def eval_mode_except_rnn(policy: nn.Module) -> None:
    """Evaluation mode, so that no dropout disturbs the ratios.

    Recurrent layers stay in training mode, as cuDNN needs.
    """
    policy.eval()
    for module in policy.modules():
        if isinstance(module, nn.RNNBase) and not module.dropout:
            module.train()


def mean_figures(figures: list[Mapping[str, float]]) -> dict[str, float]:
    """Mean of each figure over minibatches.

    Args:
        figures: one mapping per minibatch, all with the same names.
    """
    return {name: sum(one[name] for one in figures) / len(figures) for name in figures[0]}


def finite(tensor: Tensor) -> bool:
    """Whether all values of a tensor are finite."""
    return bool(torch.isfinite(tensor).all())
