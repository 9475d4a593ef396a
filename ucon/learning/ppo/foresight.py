"""Foretelling the way: going to which view shortens the way to the target, and by how much for each move.

An auxiliary task with a label for every view of every decision, where a reward comes once an episode. The label knows
the home and the target (``UcONSearch-v0`` with ``distance_to_goal=True``); who foretells it sees what the agent sees.
So it learns what a home that looks like this is likely to be beyond its frontiers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import torch
from torch import Tensor

from ucon.core.errors import ConfigError, brief
from ucon.search.view_tokens import moves_to

#: The label's name among the frames.
DISTANCE_TO_GOAL: Final = "distance_to_goal"


class ForesightLoss:
    """Squared error of what is foretold.

    Args:
        weight: beside the other losses; 0 learns none of it.

    Raises:
        ConfigError: a weight out of range.
    """

    def __init__(self, weight: float = 1.0) -> None:
        if type(weight) not in (int, float) or not 0 <= weight < 1e9:
            raise ConfigError(f"learner.foresight.weight={brief(weight)}: must be a number from 0 up")
        self.weight = weight

    def __call__(self, frames: Mapping[str, Tensor], foretold: Tensor) -> tuple[Tensor, dict[str, float]]:
        """The weighted loss, a scalar, and figures.

        Args:
            frames: of n decisions, as they were played.
            foretold: (n, V).
        """
        shortened, told = progress(frames)
        error = ((foretold - shortened)[told] ** 2).mean() if bool(told.any()) else foretold.sum() * 0.0
        spread = shortened[told].var() if int(told.sum()) > 1 else torch.ones(())
        figures = {"foresight_loss": float(error.detach()), "foreseen": float(1 - error.detach() / spread)}
        return self.weight * error, figures


def progress(frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor]:
    """By how much each move to a view shortens the way, (n, V) in [-1, 1], and where that is known, (n, V) bool."""
    distance_to_goal, views = frames[DISTANCE_TO_GOAL].float(), frames["views"].float()
    moves = moves_to(views)
    here, there = distance_to_goal[:, -1:], distance_to_goal[:, :-1]
    told = (frames["action_mask"] > 0) & (here >= 0) & (there >= 0) & (moves > 0.5)
    return torch.where(told, (here - there) / moves.clamp(min=1.0), 0.0).clamp(-1, 1), told
