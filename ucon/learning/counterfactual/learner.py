"""``learner=counterfactual``: a network that scores views learns what going to each of them would have led to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor, nn

from ucon.learning.counterfactual.labels import Rollouts
from ucon.learning.decisions.decisions import Decisions, first_views
from ucon.learning.decisions.learner import DecisionLearner, centred
from ucon.learning.decisions.store import store_hash
from ucon.learning.foresight.labels import Beyond
from ucon.learning.foresight.learner import foreseen, foresight_loss, foresight_sums
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.run.option_checks import check
from ucon.learning.run.protocol import Figures

#: Relative worth that a unit of a logit stands for. With it, the initial logits, 10 times log gain over cost, have
#: the scale that fits best over all views.
_UNIT: Final = 0.003
#: Mean worth that is assumed for decisions of less worth.
_LEAST: Final = 0.005


class CounterfactualLearner(DecisionLearner):
    """Fits the scores of views to their outcome in rollouts; see :class:`DecisionLearner`.

    Only differences between the views of a decision are learned: effects of the home, the habits and the search so far
    that are common to all views cancel out. Rollouts are slow, but what lies beyond views can be labelled without
    them; so this is learned first, from many searches, and then both.

    Args:
        policy: see :class:`DecisionLearner`.
        search: makes an environment of :class:`ucon.envs.search.twin_env.TwinSearchEnv` with a detector.
        detectors: see :class:`DecisionLearner`.
        rollouts: which decisions and views are labelled, and how.
        beyond: which decisions of further searches are labelled by what lies beyond their views.
        beyond_searches: how many such searches.
        foresight_first: share of the steps, at the start, in which only what lies beyond views is learned.
        options: see :class:`DecisionLearner`.
    """

    learns = "the outcome of going to each of several views in rollouts"

    def __init__(
        self,
        policy: nn.Module,
        search: Callable[..., Any],
        detectors: Mapping[str, Any],
        rollouts: Rollouts,
        beyond: Beyond,
        beyond_searches: int,
        foresight_first: float,
        **options: Any,
    ) -> None:
        check("above 0 and whole", lambda x: x > 0, (int,), beyond_searches=beyond_searches)
        check("from 0 to 1", lambda x: 0 <= x <= 1, (int, float), foresight_first=foresight_first)
        self.labels, self._beyond, self._beyond_searches = rollouts, beyond, beyond_searches
        self._foresight_first = foresight_first
        super().__init__(policy, search, detectors, **options)

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of both kinds of decisions and, if given, of the initial weights."""
        o = self.options
        stores = [store_hash(self._beyond, o.episodes, make, o.levels, 0) for make in self._makers]
        return {**super().identity, "beyond": f"{' '.join(stores)} {self._beyond_searches}"}

    @cached_property
    def views(self) -> Decisions:
        """Training decisions that are labelled by what lies beyond their views."""
        return self.kept(self._beyond, self.options.episodes, self._beyond_searches)

    def loss_of_step(self, draw: np.random.Generator) -> Tensor:
        """Loss of foresight and, after the first part of the training, also of the relative worth."""
        loss = foresight_loss(*self.outputs(self.drawn(self.views, draw)))
        if self._done < self._foresight_first * self.options.steps:
            return loss
        outputs, frames = self.outputs(self.drawn(self.decisions, draw))
        return loss + foresight_loss(outputs, frames) + self.loss(outputs, frames)

    def loss(self, outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
        """Mean squared error of the relative worth, in units of its variance, weighted by the decisions' worth."""
        off, worth, weight = _errors(outputs, frames)
        return (weight * off**2).sum() / (weight * worth**2).sum().clamp(min=1e-9)

    def validate(self) -> Figures:
        """Figures of the averaged network in homes that it was not trained on.

        ``foreseen``: see :func:`~ucon.learning.foresight.learner.foreseen`; ``explained``: share of the variance of the
        relative worth within decisions; ``gain``: how much more expected SPL the tried view of the highest score is
        worth than the first by gain over cost, in the mean over decisions. ``score`` is ``explained``.
        """
        s = self.validated(_sums)
        explained = 1.0 - s["off"] / max(s["spread"], 1e-9)
        gain = s["gain"] / max(s["n"], 1.0)
        return {**foreseen(s), "explained": round(explained, 5), "gain": round(gain, 6), "score": explained}


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


def _errors(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Errors and true values (n, V) of the relative worth, 0 where not tried, and weights (n, 1) of the decisions."""
    relative, known, weight = relative_worth(frames)
    chosen = outputs.logits.isfinite()  # as stored values are rounded, a labelled view may be just outside the rivals
    off = centred(_UNIT * torch.where(chosen, outputs.logits, 0.0), known & chosen)
    return off - torch.where(chosen, relative, 0.0), relative, weight


def _sums(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> dict[str, float]:
    """Sums over n decisions, from which the figures of a validation are computed."""
    off, relative, weight = _errors(outputs, frames)
    worth = frames[Rollouts.label].float()
    known, worth = ~worth.isnan(), worth.nan_to_num()
    liked = torch.where(known, outputs.logits, float("-inf")).argmax(1, keepdim=True)
    plain = {name: frames[name].float().cpu().numpy() for name in ("prior", "views", "action_mask")}
    first = torch.from_numpy(first_views(plain)).to(worth.device)[:, None]
    return {
        **foresight_sums(outputs, frames),
        "n": float(len(worth)), "off": float((weight * off**2).sum()), "spread": float((weight * relative**2).sum()),
        "gain": float((worth.gather(1, liked) - worth.gather(1, first)).sum()),
    }  # fmt: skip
