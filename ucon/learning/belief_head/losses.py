"""Losses of the belief head against the distribution that placements are drawn from."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from torch.nn import functional

from ucon.learning.belief_head.draws import Truth


def losses(outputs: Any, truth: Truth) -> dict[str, Tensor]:
    """Loss terms of one sample.

    ``anchor`` is the cross-entropy to the true distribution over candidates and "unseen"; ``relation`` is the
    cross-entropy of relations at the true anchors; ``relevance`` is a weighted binary cross-entropy of "the habit is
    about the target".

    Args:
        outputs: a head's :class:`models.nets.belief.belief_head.HeadOutputs`.
        truth: labels of the same targets, candidates and habits.

    Returns:
        Scalar tensors by name, in nats.
    """
    anchor, relation = torch.from_numpy(truth.anchor), torch.from_numpy(truth.relation)
    weight = torch.from_numpy(truth.weight)
    log_p = outputs.log_p.clamp_min(-30.0)
    anchor_loss = -(anchor * log_p).sum(1).mean()
    relation_loss = -(relation * outputs.relation.log_softmax(-1)).sum() / relation.sum().clamp_min(1e-6)
    relevant = torch.from_numpy(truth.relevant)
    relevance_loss = functional.binary_cross_entropy_with_logits(
        outputs.relevance, relevant, weight=weight, reduction="sum"
    )
    return {
        "anchor": anchor_loss,
        "relation": relation_loss,
        "relevance": relevance_loss / weight.sum().clamp_min(1e-6),
    }
