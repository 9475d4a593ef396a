"""Auxiliary task of policies over views: by how much does going to each view shorten the way to the target?

Rewards come once per episode; this gives a label for every view of every decision. The label is computed from the home
and the target's true place (``UcONSearch-v0`` with ``distance_to_goal=True``); the network sees only what the agent
sees. So it learns what is likely to lie beyond the frontiers of a home that looks like this one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import torch
from torch import Tensor

from ucon.core.errors import ConfigError, brief
from ucon.search.view_tokens import moves_to

#: Name of the label among the frames: remaining path length to the target, from each view and from here.
DISTANCE_TO_GOAL: Final = "distance_to_goal"


class ForesightLoss:
    """Mean squared error of the predicted progress.

    Args:
        weight: beside the other losses; 0 leaves it out.

    Raises:
        ConfigError: a weight out of range.
    """

    def __init__(self, weight: float = 1.0) -> None:
        if type(weight) not in (int, float) or not 0 <= weight < 1e9:
            raise ConfigError(f"learner.foresight.weight={brief(weight)}: must be a number from 0 up")
        self.weight = weight

    def __call__(self, frames: Mapping[str, Tensor], predicted: Tensor) -> tuple[Tensor, dict[str, float]]:
        """Loss of n decisions.

        Args:
            frames: of n decisions as they were played, by name.
            predicted: (n, V) predicted progress per move.

        Returns:
            The weighted loss, a scalar, and figures: ``foresight_loss``, and ``foreseen``, the share of variance
                explained.
        """
        shortened, known = progress(frames)
        error = ((predicted - shortened)[known] ** 2).mean() if bool(known.any()) else predicted.sum() * 0.0
        spread = shortened[known].var() if int(known.sum()) > 1 else torch.ones(())
        figures = {"foresight_loss": float(error.detach()), "foreseen": float(1 - error.detach() / spread)}
        return self.weight * error, figures


def progress(frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor]:
    """True progress of each view: by how much each move towards it shortens the way to the target.

    Args:
        frames: of n decisions, by name.

    Returns:
        (n, V) float32 in [-1, 1], 0 where unknown; and (n, V) bool, True where it is known.
    """
    distance_to_goal, views = frames[DISTANCE_TO_GOAL].float(), frames["views"].float()
    moves = moves_to(views)
    here, there = distance_to_goal[:, -1:], distance_to_goal[:, :-1]
    known = (frames["action_mask"] > 0) & (here >= 0) & (there >= 0) & (moves > 0.5)
    return torch.where(known, (here - there) / moves.clamp(min=1.0), 0.0).clamp(-1, 1), known
