"""Affordances: whether things of a category have a top, an inside or space below, and room for a target there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.objects.models import build_model
from ucon.perception.places.place_kernels import NEXTTO

#: Kinds of things: the catalogue's role, and for fixed things where they are mounted.
Kind = Literal["fixed_furniture", "movable_furniture", "fixture", "wall", "ceiling", "movable", "structure"]
_FIXED: dict[str, Kind] = {"wall": "wall", "ceiling": "ceiling"}


@dataclass(frozen=True)
class Affordance:
    """Which relations a category offers to a target, by the catalogue.

    Attributes:
        ontop: has a surface.
        inside: has a compartment.
        under: has space below.
        openable: has doors or drawers that Open opens.
        drawers: has drawers.
        furniture: is furniture, not a small thing.
        kind: for weights by kind of thing.
    """

    ontop: bool
    inside: bool
    under: bool
    openable: bool
    drawers: bool
    furniture: bool
    kind: Kind = "movable"

    @cached_property
    def offers(self) -> NDArray[np.bool_]:
        """(3,) bool: ontop, inside, under. Next to a thing there is always room."""
        return np.array([self.ontop, self.inside or self.openable, self.under])


@lru_cache(maxsize=4096)
def affordance(category: str) -> Affordance:
    """Affordances of a category, by the catalogue; computed once.

    A name outside the catalogue counts as a plain thing with a top.
    """
    book = catalogue()
    if category not in book:
        return Affordance(True, False, False, False, False, False)
    row, model = book[category], build_model(category)
    drawers = any(joint.kind == "prismatic" for joint in model.joints)
    furniture = row.role in ("fixed_furniture", "movable_furniture", "fixed")
    surface = bool(model.surfaces) and row.mount != "ceiling"
    kind: Kind = _FIXED.get(row.mount, "fixture") if row.role == "fixed" else row.role
    return Affordance(surface, bool(model.compartments), bool(model.under), row.openable, drawers, furniture, kind)


@lru_cache(maxsize=4096)
def sight_range_m(category: str, min_pixels: float = 5.0) -> float:
    """How far away a thing of a category can be seen, in metres of optical depth.

    Args:
        category: its catalogue size decides; 0.1 m a side outside the catalogue.
        min_pixels: the thing must cover this many pixels in a 128 x 128 view of 90 degrees.

    Returns:
        A distance from 1.2 to 4.5 m.
    """
    book = catalogue()
    x, y, z = sorted(book[category].size) if category in book else (0.1, 0.1, 0.1)
    area = (x * y + x * z + y * z) / 3
    return float(np.clip(64.0 * np.sqrt(area / min_pixels), 1.2, 4.5))


@lru_cache(maxsize=65536)
def has_room(target: str, category: str) -> tuple[bool, bool, bool]:
    """Whether a target fits on top of, into, and under a thing, by their catalogue sizes.

    Args:
        target: category of the target.
        category: category of the thing.

    Returns:
        (ontop, inside, under); all True for names outside the catalogue.
    """
    book = catalogue()
    if target not in book or category not in book:
        return True, True, True
    small, middle, large = sorted(book[target].size)
    wide, deep, high = book[category].size
    ontop = small <= 1.1 * min(wide, deep) and middle <= 1.1 * max(wide, deep)
    inside = all(a <= b for a, b in zip((small, middle, large), sorted((wide, deep, high)), strict=True))
    return ontop, inside, small <= 0.7 * high


def with_fallback(mass: NDArray[np.float64], categories: Sequence[str]) -> NDArray[np.float64]:
    """Move the mass of relations that things cannot offer to "next to".

    Args:
        mass: (n, 4) mass of ontop, inside, under, nextto.
        categories: of the n things.

    Returns:
        (n, 4) float64 with the same sums.
    """
    out = np.where(np.array([_offered(category) for category in categories]).reshape(-1, 4), mass, 0.0)
    out[:, NEXTTO] += mass.sum(1) - out.sum(1)
    return out


@lru_cache(maxsize=4096)
def _offered(category: str) -> tuple[bool, ...]:
    """Whether a thing offers ontop, inside, under, nextto."""
    return (*affordance(category).offers.tolist(), True)
