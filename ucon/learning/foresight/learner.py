"""``learner=foresight``: a network that scores views learns what lies beyond them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import torch
from torch import Tensor, nn

from ucon.learning.decisions.learner import DecisionLearner, centred
from ucon.learning.foresight.labels import Beyond
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.run.protocol import Figures

#: Smaller shares are raised to this one: otherwise their logarithms would outweigh what matters.
_LEAST: Final = 1e-3


class ForesightLearner(DecisionLearner):
    """Trains the foresight of a network; see :class:`DecisionLearner`.

    Args:
        policy: see :class:`DecisionLearner`.
        search: makes an environment of :class:`ucon.envs.search.twin_env.TwinSearchEnv` with a detector.
        detectors: see :class:`DecisionLearner`.
        beyond: which decisions are labelled.
        options: see :class:`DecisionLearner`.
    """

    learns = "what lies beyond each view"

    def __init__(
        self,
        policy: nn.Module,
        search: Callable[..., Any],
        detectors: Mapping[str, Any],
        beyond: Beyond,
        **options: Any,
    ) -> None:
        self.labels = beyond
        super().__init__(policy, search, detectors, **options)

    def loss(self, outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
        """See :func:`foresight_loss`."""
        return foresight_loss(outputs, frames)

    def validate(self) -> Figures:
        """Figures of the averaged network in homes that it was not trained on; see :func:`foreseen`."""
        figures = foreseen(self.validated(foresight_sums))
        return {**figures, "score": figures["foreseen"]}


def foresight_loss(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
    """Mean squared error of the logarithm of what lies beyond the views that are offered.

    Args:
        outputs: of a network, for n decisions.
        frames: the decisions, with ``beyond`` (n, V, R).
    """
    off, _, offered = _errors(outputs, frames)
    return (off**2 * offered[..., None]).sum() / (offered.sum() * off.shape[-1]).clamp(min=1)


def foresight_sums(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> dict[str, float]:
    """Sums over n decisions, from which :func:`foreseen` computes the shares of variance."""
    off, truth, offered = _errors(outputs, frames)
    out = {}
    for k in range(truth.shape[-1]):
        out[f"off {k}"] = float((centred(off[..., k], offered) ** 2).sum())
        out[f"spread {k}"] = float((centred(truth[..., k], offered) ** 2).sum())
    return out


def foreseen(sums: Mapping[str, float]) -> dict[str, float]:
    """``foreseen``: share of the variance within decisions that is explained, averaged over the numbers of moves."""
    spreads = {name.removeprefix("spread "): value for name, value in sums.items() if name.startswith("spread ")}
    shares = [1.0 - sums[f"off {k}"] / max(spread, 1e-9) for k, spread in spreads.items()]
    return {"foreseen": round(sum(shares) / len(shares), 5)}


def _errors(outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Errors and true logarithms (n, V, R), and which views are offered (n, V) bool."""
    assert outputs.foresight is not None
    truth = frames[Beyond.label].float().clamp(min=_LEAST).log10()
    return outputs.foresight - truth, truth, torch.as_tensor(frames["action_mask"] > 0)
