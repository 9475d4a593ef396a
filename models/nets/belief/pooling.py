"""Pools a varying number of habits into features of fixed length, each habit weighted by its relevance."""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor

from ucon.readers.head_inputs import N_PAIR, SMALL

#: Number of strongest habits that one of the means is taken over.
FEW: Final = 3
#: Columns of :func:`pooled`: three for each pair feature except the last, which does not depend on the habit.
N_POOLS: Final = 3 * (N_PAIR - 1)
#: Brings pooled values, mostly below 0.25, to about 1.
_SCALE: Final = 4.0


def strongest(gate: Tensor, said: Tensor) -> Tensor:
    """Largest gated evidence for each candidate, (T, C); 0 without habits.

    Args:
        gate: (T, H) weight of each habit.
        said: (H, C) evidence of each habit for each candidate.
    """
    if not len(said):
        return gate.new_zeros(len(gate), said.shape[1])
    return (gate[..., None] * said).amax(1)


def pooled(gate: Tensor, pair: Tensor) -> Tensor:
    """Pair features pooled over the habits: of the strongest habit, mean of the three strongest, and mean of all.

    Args:
        gate: (T, H) weight of each habit.
        pair: (H, C, N_PAIR) features.

    Returns:
        (T, C, N_POOLS); 0 without habits.
    """
    said_log = 1 + pair[..., N_PAIR - 2 : N_PAIR - 1] / -math.log(SMALL)  # 0 where nothing is said, like other columns
    pair = torch.cat([pair[..., : N_PAIR - 2].clamp_min(0), said_log], -1)  # negative values mark missing features
    h, c, p = pair.shape
    if not h:
        return gate.new_zeros(len(gate), c, 3 * p)
    few = (gate[:, :, None, None] * pair).topk(min(FEW, h), dim=1).values  # (T, 3, C, P)
    mean = torch.einsum("th,hcp->tcp", gate, pair) / (1 + gate.sum(1))[:, None, None]
    return _SCALE * torch.cat([few[:, 0], few.sum(1) / FEW, mean], -1)
