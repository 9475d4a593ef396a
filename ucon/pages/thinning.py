"""Curves of few points: what a picture of some hundred pixels can show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

_Point = TypeVar("_Point")


def thinned(points: Sequence[_Point], most: int) -> list[_Point]:
    """Some of the points of a curve, evenly, the last among them.

    Args:
        points: of the curve, in order.
        most: how many at most, at least 1.
    """
    every = max(1, -(-len(points) // most))
    return list(points[::-1][::every][::-1])
