"""``learner=foresight``: a network that scores views learns by how much each view shortens the way to the target."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

from ucon.learning.decisions.learner import DecisionLearner, centred
from ucon.learning.foresight.labels import WaysToTarget
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.ppo.foresight import progress
from ucon.learning.run.protocol import Figures


class ForesightLearner(DecisionLearner):
    """Trains the foresight of a network by the true progress of views; see :class:`DecisionLearner`."""

    labels = WaysToTarget()
    learns = "by how much each view shortens the way to the target"

    def loss(self, outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
        """Mean squared error of the progress per move."""
        assert outputs.foresight is not None
        truth, known = progress(frames)
        return ((outputs.foresight - truth) ** 2)[known].mean()

    def validate(self) -> Figures:
        """Figures of the averaged network in homes that it was not trained on.

        ``foreseen``: share of variance of the progress that is explained; ``foreseen_within``: of its variance among
        the views of a decision, which is what a choice turns on. ``score`` is ``foreseen_within``.
        """
        s = self.validated(_sums)
        whole = 1.0 - s["off"] / max(s["squares"] - s["total"] ** 2 / max(s["n"], 1.0), 1e-9)
        within = 1.0 - s["off_within"] / max(s["spread_within"], 1e-9)
        return {"foreseen": round(whole, 5), "foreseen_within": round(within, 5), "score": within}


def _sums(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> dict[str, float]:
    """Sums over n decisions, from which the shares of variance are made."""
    assert outputs.foresight is not None
    truth, known = progress(frames)
    off = outputs.foresight - truth
    return {
        "n": float(known.sum()), "total": float(truth[known].sum()), "squares": float((truth**2)[known].sum()),
        "off": float((off**2)[known].sum()), "spread_within": float((centred(truth, known) ** 2).sum()),
        "off_within": float((centred(torch.where(known, off, 0.0), known) ** 2).sum()),
    }  # fmt: skip
