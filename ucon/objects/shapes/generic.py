"""Hollow shapes that several families share, and the plain shape for categories without a builder of their own."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit
from ucon.objects.model import Material
from ucon.objects.palette import RGB

OPEN_TOP_HEADROOM = 1.5
"""Things may stick out of an open top up to this multiple of its inner height."""


def plain(k: Kit) -> None:
    """A box with the surface, interior and clearance that the catalogue states."""
    x, y, z = k.size
    if k.category.container:
        open_box(k, min(0.012, 0.06 * min(x, y)))
    else:
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, z))
    if k.category.support and not k.category.container:
        rim = (1 - (k.hints.area_frac or 0.9) ** 0.5) / 2
        k.surface((-x * (0.5 - rim), x * (0.5 - rim)), (-y * (0.5 - rim), y * (0.5 - rim)), z)


def open_box(
    k: Kit,
    wall: float,
    x: tuple[float, float] | None = None,
    y: tuple[float, float] | None = None,
    z: tuple[float, float] | None = None,
    color: RGB | None = None,
    material: Material | None = None,
    floor_color: RGB | None = None,
) -> None:
    """Five panels, open on top, with the space between them."""
    hx, hy = k.size[0] / 2, k.size[1] / 2
    x0, x1 = x or (-hx, hx)
    y0, y1 = y or (-hy, hy)
    z0, z1 = z or (0.0, k.size[2])
    k.box((x0, x1), (y0, y1), (z0, z0 + wall), floor_color or color, material)
    k.box((x0, x0 + wall), (y0, y1), (z0 + wall, z1), color, material)
    k.box((x1 - wall, x1), (y0, y1), (z0 + wall, z1), color, material)
    k.box((x0 + wall, x1 - wall), (y0, y0 + wall), (z0 + wall, z1), color, material)
    k.box((x0 + wall, x1 - wall), (y1 - wall, y1), (z0 + wall, z1), color, material)
    depth = (z1 - z0 - wall) * OPEN_TOP_HEADROOM
    k.space((x0 + wall, x1 - wall), (y0 + wall, y1 - wall), (z0 + wall, z0 + wall + depth))


def ring(
    k: Kit,
    rx: float,
    ry: float,
    z: tuple[float, float],
    wall: float,
    color: RGB | None = None,
    material: Material | None = None,
    sides: int = 8,
    cx: float = 0.0,
    cy: float = 0.0,
) -> None:
    """Upright panels around an ellipse of outer half axes ``rx``, ``ry``: the wall of something round and hollow."""
    ax, ay = rx - wall / 2, ry - wall / 2
    for i in range(sides):
        a, b = 2 * pi * (i - 0.5) / sides, 2 * pi * (i + 0.5) / sides
        px, py, qx, qy = ax * cos(a), ay * sin(a), ax * cos(b), ay * sin(b)
        k.panel((cx + px, cy + py), (cx + qx, cy + qy), wall, z, color, material)


def torus(
    k: Kit,
    middle: float,
    thick: float,
    z: tuple[float, float],
    color: RGB | None = None,
    material: Material | None = None,
    count: int = 8,
) -> None:
    """A flat ring of bars: ``middle`` radius and ``thick`` width as fractions of the footprint."""
    for i in range(count):
        a, b = 2 * pi * i / count, 2 * pi * (i + 1.08) / count
        height = (z[1] - z[0]) * k.size[2]
        width = thick * min(k.size[0], k.size[1])
        p = (middle * cos(a), middle * sin(a), (z[0] + z[1]) / 2)
        q = (middle * cos(b), middle * sin(b), (z[0] + z[1]) / 2)
        k.rod(p, q, (height, width), color, material)
