"""``learner=counterfactual``: a network that scores views learns what would have come of going to each of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import torch
from torch import Tensor, nn

from ucon.learning.counterfactual.labels import Rollouts
from ucon.learning.decisions.decisions import first_views
from ucon.learning.decisions.learner import DecisionLearner, centred
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.run.protocol import Figures

#: Relative worth that a unit of a view's logit stands for: so gain over cost, with its initial factor of 10, fits best.
_UNIT: Final = 0.0065
#: Decisions of less worth count as if they had so much.
_LEAST: Final = 0.005


class CounterfactualLearner(DecisionLearner):
    """Fits the scores of views to what came of them in rollouts; see :class:`DecisionLearner`.

    Only differences between the views of a decision are learned: what the home, the habits and the search so far make
    of all of them alike cancels.

    Args:
        policy: see :class:`DecisionLearner`.
        searches: make environments of :class:`ucon.envs.search.twin_env.TwinSearchEnv`, by name.
        rollouts: which decisions and views are labelled, and how.
        options: see :class:`DecisionLearner`.
    """

    learns = "what came of going to each of several views in rollouts"

    def __init__(
        self, policy: nn.Module, searches: Mapping[str, Callable[[], Any]], rollouts: Rollouts, **options: Any
    ) -> None:
        self.labels = rollouts
        super().__init__(policy, searches, **options)

    def loss(self, outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
        """Mean squared error of the relative worth, in units of its variance, weighted by the decisions' worth."""
        worth, known, weight = relative_worth(frames)
        off = centred(_UNIT * _finite(outputs.logits), known) - worth
        return (weight * off**2).sum() / (weight * worth**2).sum().clamp(min=1e-9)

    def validate(self) -> Figures:
        """Figures of the averaged network in homes that it was not trained on.

        ``explained``: share of the variance of the relative worth within decisions; ``gain``: expected SPL by which the
        view that is liked best is worth more than the first by gain over cost, in the mean over decisions. ``score`` is
        ``explained``.
        """
        s = self.validated(_sums)
        explained = 1.0 - s["off"] / max(s["spread"], 1e-9)
        return {"explained": round(explained, 5), "gain": round(s["gain"] / max(s["n"], 1.0), 6), "score": explained}


def relative_worth(frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Labels of n decisions: the worth of views relative to the mean over the views that were tried, less 1.

    Args:
        frames: by name, with ``worth`` (n, V), nan where a view was not tried.

    Returns:
        Relative worth (n, V) float32, 0 where not tried; which were tried (n, V) bool; and the mean worth (n, 1).
    """
    worth = frames[Rollouts.label].float()
    known = ~worth.isnan()
    mean = worth.nan_to_num().sum(1, keepdim=True) / known.sum(1, keepdim=True).clamp(min=1)
    return centred(worth.nan_to_num(), known) / mean.clamp(min=_LEAST), known, mean


def _finite(logits: Tensor) -> Tensor:
    """Logits, 0 where there is no view."""
    return torch.where(logits.isfinite(), logits, 0.0)


def _sums(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> dict[str, float]:
    """Sums over n decisions, of which the figures of a validation are made."""
    relative, known, weight = relative_worth(frames)
    off = centred(_UNIT * _finite(outputs.logits), known) - relative
    worth = frames[Rollouts.label].float().nan_to_num()
    liked = torch.where(known, outputs.logits, float("-inf")).argmax(1, keepdim=True)
    plain = {name: frames[name].float().cpu().numpy() for name in ("prior", "views", "action_mask")}
    first = torch.from_numpy(first_views(plain)).to(worth.device)[:, None]
    return {
        "n": float(len(worth)), "off": float((weight * off**2).sum()), "spread": float((weight * relative**2).sum()),
        "gain": float((worth.gather(1, liked) - worth.gather(1, first)).sum()),
    }  # fmt: skip
