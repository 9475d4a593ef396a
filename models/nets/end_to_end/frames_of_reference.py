"""Frames of reference of the end-to-end policy: the start's, the agent's, and where the target was last seen."""

from __future__ import annotations

import torch
from torch import Tensor

from models.nets.end_to_end.ego_view import CELL_M


def cosines(quarters: Tensor) -> tuple[Tensor, Tensor]:
    """Cosine and sine of quarter turns, float32."""
    c = torch.tensor([1.0, 0.0, -1.0, 0.0], device=quarters.device)[quarters]
    return c, torch.tensor([0.0, 1.0, 0.0, -1.0], device=quarters.device)[quarters]


def turned(pose: Tensor, quarters: Tensor) -> Tensor:
    """Poses (..., B, 4) as they would be if the start had looked another way, by ``quarters`` (B,) to the left."""
    c, s = (part.to(pose.dtype) for part in cosines(quarters))
    i, j, heading, look = pose.unbind(-1)
    return torch.stack([c * i - s * j, s * i + c * j, (heading + quarters.to(pose.dtype)) % 4, look], -1)


def target_at(before: Tensor, seen: Tensor, thing: Tensor, pose: Tensor) -> Tensor:
    """(B, 4): whether the target was seen; where, in metres from the start and above the camera.

    ``before`` (B, 4) is kept where it is not ``seen`` (B,); ``thing`` (B, F) begins with metres ahead, to the left, up.
    """
    c, s = cosines(pose[:, 2])
    x = CELL_M * pose[:, 0] + c * thing[:, 0] - s * thing[:, 1]
    y = CELL_M * pose[:, 1] + s * thing[:, 0] + c * thing[:, 1]
    return torch.where(seen[:, None], torch.stack([torch.ones_like(x), x, y, thing[:, 2]], -1), before)


def from_here(place: Tensor, pose: Tensor) -> Tensor:
    """(B, 5): whether the target was seen; metres / 4 ahead, to the left, up; and away."""
    c, s = cosines(pose[:, 2])
    known = place[:, 0]
    dx, dy = place[:, 1] - CELL_M * pose[:, 0], place[:, 2] - CELL_M * pose[:, 1]
    away = torch.stack([c * dx + s * dy, c * dy - s * dx, place[:, 3], torch.hypot(dx, dy)], -1)
    return torch.cat([known[:, None], 0.25 * away * known[:, None]], -1)
