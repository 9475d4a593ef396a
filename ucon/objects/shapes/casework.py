"""Parts of furniture that opens: hollow bodies, door leaves, drop doors, drawers and lids, each with its joint.

When closed, every front overlaps the edges of the body behind it, and every seam between two fronts has a strip or
rail behind it, so nothing inside can be seen. Leaves swing to 90 degrees about an axis as far from their outer edge as
the handle sticks out, which keeps an open leaf within the width of its own unit, so neighbouring units never touch.
"""

from __future__ import annotations

from math import pi, radians

from ucon.objects.kit import Kit
from ucon.objects.model import Material
from ucon.objects.palette import DARK, RGB, shade

Span = tuple[float, float]
BOARD = 0.02
HANDLE = 0.012
RIGHT_ANGLE = pi / 2
DROP = radians(85)
EYE_M = 1.25
"""Height from which people and robots look."""


def seen_depth(floor: float, ceiling: float, setback: float = 0.0) -> float:
    """How far behind the front things can lie and still be seen by somebody standing within a metre of them.

    Args:
        floor: Height above the ground on which they stand.
        ceiling: Height of the board above them.
        setback: How far the edge of that board lies behind the front.
    """
    if ceiling > EYE_M - 0.05:
        return 10.0
    ratio = (ceiling - floor - 0.03) / (EYE_M - ceiling)
    return setback + 0.95 * ratio / (1 + ratio)


def carcass(
    k: Kit, x: Span, y: Span, z: Span, board: float = BOARD, color: RGB | None = None
) -> tuple[Span, Span, Span]:
    """Back, sides, top and bottom, open at the larger x. Returns the inner spans (x, y, z)."""
    k.box((x[0], x[0] + board), y, z, color)
    inner_x, inner_y, inner_z = (x[0] + board, x[1]), (y[0] + board, y[1] - board), (z[0] + board, z[1] - board)
    k.box(inner_x, (y[0], inner_y[0]), z, color)
    k.box(inner_x, (inner_y[1], y[1]), z, color)
    k.box(inner_x, inner_y, (z[0], inner_z[0]), color)
    k.box(inner_x, inner_y, (inner_z[1], z[1]), color)
    return inner_x, inner_y, inner_z


def leaves(
    k: Kit,
    front: float,
    y: Span,
    z: Span,
    color: RGB | None = None,
    pair: bool | None = None,
    hinge_low_y: bool = False,
    handle: RGB = DARK,
    thickness: float = BOARD,
) -> tuple[int, ...]:
    """One leaf, or two when the opening is wider than 0.6 m, with their handles; ``front`` is the handles' face.

    A single leaf turns about its edge at the larger y unless ``hinge_low_y``.
    """
    face = front - HANDLE
    back = face - thickness
    middle = (y[0] + y[1]) / 2
    handle_z = _handle_span(z)
    if pair is None:
        pair = y[1] - y[0] > 0.6
    if not pair:
        edge, sign, grip = (y[0], -1.0, y[1] - 0.05) if hinge_low_y else (y[1], 1.0, y[0] + 0.05)
        joint = k.hinge((face, edge - sign * HANDLE, z[0]), (0.0, 0.0, sign), RIGHT_ANGLE)
        k.box((back, face), y, z, color, k.material, link=joint)
        k.box((face, front), (grip - 0.01, grip + 0.01), handle_z, handle, Material.METAL, link=joint)
        return (joint,)
    left = k.hinge((face, y[1] - HANDLE, z[0]), (0.0, 0.0, 1.0), RIGHT_ANGLE)
    right = k.hinge((face, y[0] + HANDLE, z[0]), (0.0, 0.0, -1.0), RIGHT_ANGLE)
    k.box((back, face), (middle, y[1]), z, color, k.material, link=left)
    k.box((back, face), (y[0], middle), z, shade(color or k.color, 0.97), k.material, link=right)
    # The strip behind the seam belongs to one leaf; it stays clear of the body's boards.
    k.box((back - 0.012, back), (middle - 0.015, middle + 0.015), (z[0] + 0.03, z[1] - 0.03), color, link=left)
    k.box((face, front), (middle + 0.03, middle + 0.05), handle_z, handle, Material.METAL, link=left)
    k.box((face, front), (middle - 0.05, middle - 0.03), handle_z, handle, Material.METAL, link=right)
    return left, right


def _handle_span(z: Span) -> Span:
    middle = (z[0] + z[1]) / 2
    reach = min(0.08, (z[1] - z[0]) * 0.3)
    return middle - reach, middle + reach


def drop_door(
    k: Kit, front: float, y: Span, z: Span, color: RGB | None = None, handle: RGB = DARK, window: RGB | None = None
) -> int:
    """A door that falls forward about its bottom front edge, with a bar handle near its top."""
    face = front - HANDLE
    joint = k.hinge((face, (y[0] + y[1]) / 2, z[0]), (0.0, 1.0, 0.0), DROP)
    k.box((face - BOARD, face), y, z, color, k.material, link=joint)
    width, height = y[1] - y[0], z[1] - z[0]
    k.box((face, front), (y[0] + 0.1 * width, y[1] - 0.1 * width), (z[1] - 0.16 * height, z[1] - 0.08 * height), handle,
          Material.METAL, link=joint)  # fmt: skip
    if window is not None:
        k.box((face, face + 0.004), (y[0] + 0.12 * width, y[1] - 0.12 * width),
              (z[0] + 0.15 * height, z[0] + 0.75 * height), window, Material.GLASS, link=joint)  # fmt: skip
    return joint


def drawer(
    k: Kit,
    body_x: Span,
    front: float,
    y: Span,
    z: Span,
    travel: float,
    color: RGB | None = None,
    above: float = 0.0,
) -> int:
    """A front with handle, and the open box behind it; content is carried by the joint.

    The box spans ``body_x``; content goes to the part of it that is visible when this drawer and the one above it are
    open; ``above`` is how far the upper one comes out.
    """
    joint = k.slide((front, (y[0] + y[1]) / 2, z[0]), travel)
    face = front - HANDLE
    k.box((body_x[1], face), y, z, color, k.material, link=joint)
    middle, height = (y[0] + y[1]) / 2, z[1] - z[0]
    reach = min(0.09, 0.2 * (y[1] - y[0]))
    k.box((face, front), (middle - reach, middle + reach), (z[0] + 0.5 * height, z[0] + 0.5 * height + 0.015), DARK,
          Material.METAL, link=joint)  # fmt: skip
    inner_y = (y[0] + BOARD + 0.012, y[1] - BOARD - 0.012)
    low, high = z[0] + 0.012, z[1] - max(0.03, 0.2 * height)
    inside = shade(color or k.color, 1.25)
    k.box(body_x, inner_y, (low, low + 0.008), inside, link=joint)
    k.box(body_x, (inner_y[0] - 0.008, inner_y[0]), (low, high), inside, link=joint)
    k.box(body_x, (inner_y[1], inner_y[1] + 0.008), (low, high), inside, link=joint)
    floor = k.category.bottom_z_m + low
    deepest = max(body_x[0], body_x[1] - (travel - above) - seen_depth(floor, floor + z[1] - low))
    k.space((deepest, body_x[1] - 0.035), inner_y, (low + 0.008, z[1] - 0.025), link=joint, opened_by=(joint,))
    return joint


def lid(k: Kit, x: Span, y: Span, z: Span, color: RGB | None = None, grip: float = 0.0) -> int:
    """A slab hinged at its back edge; ``grip`` is the height of what stands on it, which must clear the wall."""
    joint = k.hinge((x[0], (y[0] + y[1]) / 2, z[1] + grip), (0.0, -1.0, 0.0), RIGHT_ANGLE)
    k.box(x, y, z, color, k.material, link=joint)
    return joint


def tub(
    k: Kit, x: Span, y: Span, z: Span, wall: float, floor: float, color: RGB | None = None, inside: RGB | None = None
) -> tuple[Span, Span]:
    """Four walls and a floor whose upper face is ``floor`` above the bottom. Returns the inner spans (x, y)."""
    inner_x, inner_y = (x[0] + wall, x[1] - wall), (y[0] + wall, y[1] - wall)
    k.box((x[0], inner_x[0]), y, z, color)
    k.box((inner_x[1], x[1]), y, z, color)
    k.box(inner_x, (y[0], inner_y[0]), z, color)
    k.box(inner_x, (inner_y[1], y[1]), z, color)
    k.box(inner_x, inner_y, (z[0], z[0] + floor), inside or color)
    return inner_x, inner_y
