"""Sample points on and in a category, by its catalogue shape, and the open sides of its compartments.

Points are in units of the object's box, so that they fit whatever size of it was seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Box3, Compartment, ObjectModel, Surface
from ucon.objects.models import build_model
from ucon.perception.mapping.map_kernels import ALL_OPEN
from ucon.perception.places.place_kernels import INSIDE, ONTOP, stretch
from ucon.sim.shapes import primitive_boxes, solid_of_parts

__all__ = ["ALL_OPEN", "Template", "fit", "template"]

#: The bit of the side +z: only the top is open.
_ABOVE = 32
#: Bit numbers of the upright sides +x, +y, -x, -y (counter-clockwise).
_AROUND = (1, 3, 0, 2)
_TOP_SPACING_M = 0.5
_INNER_SPACING_M = 0.3
_DEEP_SPACING_M = 0.13
"""Spacing in compartments that are open above only: their rim hides one half of the inside or the other."""
_MOST_A_SIDE = 4
_MOST_DEEP = 3
#: Steps in which a wall is searched behind a compartment's side, out to the end of the object.
_WALL_STEP_M = 0.004
_COVERED = 0.6


@dataclass(frozen=True, eq=False)
class Template:
    """The k sample points of one category in units of its box; its front is along +x.

    Attributes:
        size: (3,) the catalogue's size, metres.
        xyz: (k, 3) x and y from -0.5 to 0.5, z from 0 to 1.
        relation: (k,) int32, ONTOP or INSIDE.
        share: (k,) share of the relation's mass; sums to 1 within a relation.
        hollow: (k, 6) box of the point's compartment, x0 y0 z0 x1 y1 z1 in the same units; zeros for ONTOP.
        faces: (k,) uint8, bits of the compartment's open sides; ALL_OPEN for ONTOP.
        lift: (k,) by how many times half the target's height the point is raised.
        turns: whether the points depend on where the front is.
    """

    size: NDArray[np.float64]
    xyz: NDArray[np.float64]
    relation: NDArray[np.int32]
    share: NDArray[np.float64]
    hollow: NDArray[np.float64]
    faces: NDArray[np.uint8]
    lift: NDArray[np.float64]
    turns: bool

    def turned_faces(self, quarters: int) -> NDArray[np.uint8]:
        """The open sides after a rotation.

        Args:
            quarters: quarter turns counter-clockwise.

        Returns:
            (k,) uint8 bits.
        """
        order = [_AROUND[(k - quarters) % 4] for k in range(4)]
        out = self.faces & np.uint8(48)
        for k in range(4):
            out |= ((self.faces >> order[k]) & 1).astype(np.uint8) << np.uint8(_AROUND[k])
        return out

    def has(self, relation: int) -> bool:
        """Whether there are points of a relation (ONTOP or INSIDE)."""
        return bool((self.relation == relation).any())


@lru_cache(maxsize=4096)
def template(category: str) -> Template:
    """The sample points of a category; computed once.

    A name outside the catalogue counts as a plain thing with a top.
    """
    book = catalogue()
    if category not in book:
        return _template(np.ones(3), _tops([Surface(-0.5, -0.5, 0.5, 0.5, 1.0, 1.0)]))
    row, model = book[category], build_model(category)
    size = np.array(row.size, float)
    rows: list[_Row] = []
    if row.mount != "ceiling":
        rows += _tops(model.surfaces)
    for compartment in model.compartments:
        rows += _inside(model, compartment, size)
    return _template(size, rows)


def fit(
    shape: Template,
    box: NDArray[np.float64],
    quarters: int,
    lift_m: float,
    rows: NDArray[np.float64],
    faces: NDArray[np.uint8],
) -> None:
    """Place a template's k points in a box.

    Args:
        shape: the template.
        box: (6,) x0 y0 z0 x1 y1 z1, metres.
        quarters: quarter turns counter-clockwise by which the thing is turned.
        lift_m: half the target's height, metres.
        rows: (k, 12) float64, written: x, y, z, relation, share, (column 5 is left), compartment x0 y0 z0 x1 y1 z1.
        faces: (k,) uint8, written: bits of the open sides.
    """
    if not len(rows):
        return
    stretch(shape.xyz, shape.lift, shape.hollow, shape.faces, box, quarters, lift_m, rows)
    rows[:, 3], rows[:, 4] = shape.relation, shape.share
    faces[:] = _turned_faces(shape, quarters)


@lru_cache(maxsize=4096)
def _turned_faces(shape: Template, quarters: int) -> NDArray[np.uint8]:
    return shape.turned_faces(quarters)


#: A sample point: xyz, relation, weight, compartment, open sides, lift.
_Row = tuple[tuple[float, float, float], int, float, Box3, int, float]
_NO_BOX: Box3 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def _template(size: NDArray[np.float64], rows: Sequence[_Row]) -> Template:
    """Put the sample points (in metres) into arrays in units of the box."""
    relation = np.array([r[1] for r in rows], np.int32)
    share = np.array([r[2] for r in rows], float)
    for kind in (ONTOP, INSIDE):
        if (relation == kind).any():
            share[relation == kind] /= share[relation == kind].sum()
    faces = np.array([r[4] for r in rows], np.uint8)
    xyz = np.array([r[0] for r in rows], float).reshape(-1, 3) / size
    hollow = np.array([r[3] for r in rows], float).reshape(-1, 6) / np.tile(size, 2)
    lopsided = (faces != ALL_OPEN) & ((faces & 15) != 0) & ((faces & 15) != 15)
    off_middle = [np.abs(xyz[relation == kind, :2].mean(0)).max() for kind in set(relation.tolist())]
    turns = bool(lopsided.any() or max(off_middle, default=0.0) > 0.05)
    return Template(size, xyz, relation, share, hollow, faces, np.array([r[5] for r in rows], float), turns)


def _tops(surfaces: Sequence[Surface]) -> list[_Row]:
    """Sample points on surfaces, weighted by area."""
    rows: list[_Row] = []
    for s in surfaces:
        cells = _lattice((s.x0, s.y0, s.x1, s.y1), _TOP_SPACING_M)
        area = (s.x1 - s.x0) * (s.y1 - s.y0) / len(cells)
        rows += [((x, y, s.z), ONTOP, area, _NO_BOX, ALL_OPEN, 1.0) for x, y in cells]
    return rows


def _inside(model: ObjectModel, compartment: Compartment, size: NDArray[np.float64]) -> list[_Row]:
    """Sample points on the floor of a compartment; those of a drawer lie where it is when pulled out."""
    x0, y0, z0, x1, y1, z1 = compartment.box
    z1 = min(z1, float(size[2]))
    faces = open_faces(model, compartment)
    if compartment.link >= 0:
        shift = model.joints[compartment.link].travel * np.array(model.joints[compartment.link].axis)
        x0, x1 = max(x0 + shift[0], 0.5 * float(size[0])), max(x1, x1 + shift[0])
        faces = _ABOVE
    box: Box3 = (x0, y0, z0, x1, y1, max(z1, z0 + 0.02))
    deep = faces == _ABOVE
    cells = _lattice(
        (x0, y0, x1, y1), _DEEP_SPACING_M if deep else _INNER_SPACING_M, _MOST_DEEP if deep else _MOST_A_SIDE
    )
    lift = 2.0 if deep else 1.0
    return [((x, y, z0), INSIDE, 1.0 / len(cells), box, faces, lift) for x, y in cells]


def _lattice(
    rect: tuple[float, float, float, float], spacing_m: float, most: int = _MOST_A_SIDE
) -> list[tuple[float, float]]:
    """Centres of a grid of cells in a rectangle (x0, y0, x1, y1); at most ``most`` a side."""
    x0, y0, x1, y1 = rect
    nx, ny = (min(max(round((b - a) / spacing_m), 1), most) for a, b in ((x0, x1), (y0, y1)))
    return [
        (x0 + (a + 0.5) * (x1 - x0) / nx, y0 + (b + 0.5) * (y1 - y0) / ny)
        for a in range(int(nx))
        for b in range(int(ny))
    ]


def open_faces(model: ObjectModel, compartment: Compartment) -> int:
    """The sides of a compartment that no fixed part covers once its doors are open.

    Its floor counts as closed. Where every side is covered (a tent with slanted walls) all count as open: a useless
    look is better than none at all.

    Args:
        model: the object.
        compartment: one of its compartments.

    Returns:
        Bits 0 to 5 for -x, +x, -y, +y, -z, +z.
    """
    fixed = tuple(part for part in model.parts if part.link not in compartment.opened_by)
    if not fixed:
        return ALL_OPEN
    walls = primitive_boxes(solid_of_parts(fixed), (0.0, 0.0, 0.0), np.eye(3))
    box = np.array(compartment.box, float)
    box[5] = min(box[5], model.size[2])
    out_m = np.concatenate([box[:3] - walls[:, :3].min(0), walls[:, 3:].max(0) - box[3:]])
    faces = 0
    for axis in range(3):
        for end in range(2):
            if _covered(box, walls, axis, end, float(out_m[3 * end + axis])) < _COVERED:
                faces |= 1 << (2 * axis + end)
    faces &= ~16  # its floor
    return faces or ALL_OPEN


def _covered(box: NDArray[np.float64], walls: NDArray[np.float64], axis: int, end: int, out_m: float) -> float:
    """Share of one side of a box behind which a wall stands, up to ``out_m`` away."""
    others = [k for k in range(3) if k != axis]
    ticks = [box[k] + (np.arange(5) + 0.5) / 5 * (box[3 + k] - box[k]) for k in others]
    a, b = np.meshgrid(*ticks, indexing="ij")
    depths = np.arange(0.004, max(out_m, 0.005), _WALL_STEP_M)
    at = box[3 + axis] + depths if end else box[axis] - depths
    behind = walls[((walls[:, axis, None] <= at) & (at <= walls[:, 3 + axis, None])).any(1)]
    low, high = behind[:, [others]].reshape(-1, 2, 1, 1), behind[:, [[k + 3 for k in others]]].reshape(-1, 2, 1, 1)
    hit = (low[:, 0] <= a) & (a <= high[:, 0]) & (low[:, 1] <= b) & (b <= high[:, 1])
    return float(hit.any(0).mean())
