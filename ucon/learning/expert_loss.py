"""Choosing as an expert would that knows the home, of networks that score views.

The label of a decision is how much nearer each of its views brings to where the expert would go
(:mod:`ucon.envs.waypoint.view_expert`), for whatever the policy itself came upon: DAgger (Ross, Gordon and Bagnell,
2011) without keeping what was collected before. Who sees less than the expert can only learn what it would do on
average in homes that look like this so far.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import torch
from torch import Tensor

from ucon.core.errors import ConfigError, brief
from ucon.envs.waypoint.view_expert import NOTHING

#: The label's name among the frames.
EXPERT: Final = "expert"


class ExpertLoss:
    """Cross-entropy to the expert's choice, softened.

    Args:
        weight: beside the other losses.
        sharpness: of the expert's choice; how much likelier, as a logarithm, straight there is than neither nearer nor
            farther.

    Raises:
        ConfigError: a number out of range.
    """

    def __init__(self, weight: float = 1.0, sharpness: float = 10.0) -> None:
        for name, number in (("weight", weight), ("sharpness", sharpness)):
            if type(number) not in (int, float) or not 0 < number < 1e9:
                raise ConfigError(f"learner.expert.{name}={brief(number)}: must be a number above 0")
        self.weight, self.sharpness = weight, sharpness

    def __call__(self, frames: Mapping[str, Tensor], logits: Tensor) -> tuple[Tensor, dict[str, float]]:
        """The weighted loss, a scalar, and figures: KL divergence from the expert, and how often both choose alike.

        Args:
            frames: of n decisions, as they were played.
            logits: (n, V), -inf where there is no view.
        """
        views, worth = frames["action_mask"] > 0, frames[EXPERT].float()
        told = (views & (worth > NOTHING)).any(-1)
        if not bool(told.any()):
            return logits.masked_fill(~views, 0.0).sum() * 0.0, {"expert_kl": 0.0, "as_expert": 0.0}
        views, worth, logits = views[told], worth[told], logits[told]
        expert = (self.sharpness * worth).masked_fill(~views, -torch.inf).log_softmax(-1)
        own = logits.masked_fill(~views, -torch.inf).log_softmax(-1)
        more = expert.masked_fill(~views, 0.0) - own.masked_fill(~views, 0.0)
        apart = (expert.exp() * more).sum(-1).mean()
        alike = (expert.argmax(-1) == own.argmax(-1)).float().mean()
        return self.weight * apart, {"expert_kl": float(apart.detach()), "as_expert": float(alike)}
