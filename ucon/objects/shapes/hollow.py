"""Round hollow forms that vessels are made of: a wall on a foot, and the space that it holds."""

from __future__ import annotations

from ucon.objects.kit import Kit
from ucon.objects.palette import shade
from ucon.objects.shapes.generic import OPEN_TOP_HEADROOM, ring

INSCRIBED = 0.70
"""Half side of the largest square in a circle of radius 1, with a little play."""


def round_space(k: Kit, rx: float, ry: float, floor: float, top: float, cx: float = 0.0, cy: float = 0.0) -> None:
    """The upright box that fits into a round hollow, with headroom above the rim."""
    hx, hy = rx * INSCRIBED, ry * INSCRIBED
    k.space((cx - hx, cx + hx), (cy - hy, cy + hy), (floor, floor + (top - floor) * OPEN_TOP_HEADROOM))


def hollow(
    k: Kit, rx: float, ry: float, low: float, top: float, wall: float, foot: float = 0.9, floor: float | None = None
) -> None:
    """A round wall on a foot of ``foot`` times its width; the inside is darker, so that the hollow is seen."""
    base = low + (floor if floor is not None else max(0.006, 0.16 * (top - low)))
    ring(k, rx, ry, (base, top), wall)
    inner_x, inner_y = rx - wall, ry - wall
    k.cyl((-rx * foot, rx * foot), (-ry * foot, ry * foot), (low, base - 0.002))
    k.cyl((-inner_x, inner_x), (-inner_y, inner_y), (base - 0.004, base + 0.001), shade(k.color, 0.75))
    round_space(k, inner_x * 0.98, inner_y * 0.98, base + 0.001, top)
