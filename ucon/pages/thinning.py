"""Thins curves to as many points as a picture of a few hundred pixels can show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

_Point = TypeVar("_Point")


def thinned(points: Sequence[_Point], most: int) -> list[_Point]:
    """Evenly spaced points of a curve, the last one included.

    Args:
        points: of the curve, in order.
        most: largest number of points to return, at least 1.
    """
    every = max(1, -(-len(points) // most))
    return list(points[::-1][::every][::-1])
