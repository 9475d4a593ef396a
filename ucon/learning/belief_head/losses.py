"""Losses of the belief head: how its distribution stands to the one that placements are drawn from."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from torch.nn import functional

from ucon.learning.belief_head.draws import Truth


def losses(outputs: Any, truth: Truth) -> dict[str, Tensor]:
    """Scalars by name.

    ``anchor``: soft cross-entropy to the whole distribution; ``relation``: the same for relations at the true
    anchors; ``relevance``: binary cross-entropy over habits, whose weights make those that support a placement count.
    ``outputs`` are a head's (:class:`models.nets.belief.belief_head.HeadOutputs`).
    """
    anchor, relation = torch.from_numpy(truth.anchor), torch.from_numpy(truth.relation)
    weight = torch.from_numpy(truth.weight)
    log_p = outputs.log_p.clamp_min(-30.0)
    said = -(anchor * log_p).sum(1).mean()
    how = -(relation * outputs.relation.log_softmax(-1)).sum() / relation.sum().clamp_min(1e-6)
    own = torch.from_numpy(truth.relevant)
    about = functional.binary_cross_entropy_with_logits(outputs.relevance, own, weight=weight, reduction="sum")
    return {"anchor": said, "relation": how, "relevance": about / weight.sum().clamp_min(1e-6)}
