"""Transformations between the start's frame, in which the map is kept, and the agent's frame."""

from __future__ import annotations

import torch
from torch import Tensor

from models.nets.end_to_end.ego_view import CELL_M


def cosines(quarters: Tensor) -> tuple[Tensor, Tensor]:
    """Cosine and sine of quarter turns, float32 of the same shape.

    Args:
        quarters: int64, 0 to 3.
    """
    c = torch.tensor([1.0, 0.0, -1.0, 0.0], device=quarters.device)[quarters]
    return c, torch.tensor([0.0, 1.0, 0.0, -1.0], device=quarters.device)[quarters]


def turned(pose: Tensor, quarters: Tensor) -> Tensor:
    """Poses as if the start had been turned by quarter turns to the left; for augmentation.

    Args:
        pose: (..., B, 4) int: cell (i, j), heading, look.
        quarters: (B,) int, 0 to 3.
    """
    c, s = (part.to(pose.dtype) for part in cosines(quarters))
    i, j, heading, look = pose.unbind(-1)
    return torch.stack([c * i - s * j, s * i + c * j, (heading + quarters.to(pose.dtype)) % 4, look], -1)


def target_at(before: Tensor, seen: Tensor, thing: Tensor, pose: Tensor) -> Tensor:
    """Update where the target was last seen.

    Args:
        before: (B, 4) 1 if it was ever seen, then x and y in metres from the start and height above the camera.
        seen: (B,) bool, whether it is seen now; elsewhere ``before`` is kept.
        thing: (B, F) features of the target, which begin with metres ahead, left and up.
        pose: (B, 4) of the agent.

    Returns:
        (B, 4) like ``before``.
    """
    c, s = cosines(pose[:, 2])
    x = CELL_M * pose[:, 0] + c * thing[:, 0] - s * thing[:, 1]
    y = CELL_M * pose[:, 1] + s * thing[:, 0] + c * thing[:, 1]
    return torch.where(seen[:, None], torch.stack([torch.ones_like(x), x, y, thing[:, 2]], -1), before)


def from_here(place: Tensor, pose: Tensor) -> Tensor:
    """The remembered target in the agent's frame.

    Args:
        place: (B, 4) of :func:`target_at`.
        pose: (B, 4) of the agent.

    Returns:
        (B, 5): 1 if it was seen, then ahead, left, up and distance in units of 4 m; 0 if it was not.
    """
    c, s = cosines(pose[:, 2])
    known = place[:, 0]
    dx, dy = place[:, 1] - CELL_M * pose[:, 0], place[:, 2] - CELL_M * pose[:, 1]
    away = torch.stack([c * dx + s * dy, c * dy - s * dx, place[:, 3], torch.hypot(dx, dy)], -1)
    return torch.cat([known[:, None], 0.25 * away * known[:, None]], -1)
