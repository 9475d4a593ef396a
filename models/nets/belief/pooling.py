"""What several habits say for a candidate, as numbers of fixed length: each counts as far as it is about the target."""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor

from ucon.readers.head_inputs import N_PAIR, SMALL

#: Of how many of the strongest habits a mean is taken.
FEW: Final = 3
#: Columns of :func:`pooled`: three for each of a pair but the last one, which says nothing about habits.
N_POOLS: Final = 3 * (N_PAIR - 1)
#: Pools are mostly below a quarter.
_SCALE: Final = 4.0


def strongest(gate: Tensor, said: Tensor) -> Tensor:
    """(T, C) the largest gated word (H, C) for each candidate; 0 without habits."""
    if not len(said):
        return gate.new_zeros(len(gate), said.shape[1])
    return (gate[..., None] * said).amax(1)


def pooled(gate: Tensor, pair: Tensor) -> Tensor:
    """(T, C, N_POOLS) of pair inputs (H, C, N_PAIR), gated (T, H): the strongest habit's, the mean of a few, of all."""
    said_log = 1 + pair[..., N_PAIR - 2 : N_PAIR - 1] / -math.log(SMALL)  # 0 where nothing is said, as in the others
    pair = torch.cat([pair[..., : N_PAIR - 2].clamp_min(0), said_log], -1)  # what is not given counts as 0
    h, c, p = pair.shape
    if not h:
        return gate.new_zeros(len(gate), c, 3 * p)
    few = (gate[:, :, None, None] * pair).topk(min(FEW, h), dim=1).values  # (T, 3, C, P)
    mean = torch.einsum("th,hcp->tcp", gate, pair) / (1 + gate.sum(1))[:, None, None]
    return _SCALE * torch.cat([few[:, 0], few.sum(1) / FEW, mean], -1)
