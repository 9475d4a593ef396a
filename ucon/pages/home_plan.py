"""The floor plan of a home as plain values, which ``data/plan.js`` draws."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import GRID_M
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House

#: Things that a plan leaves out: lamps hang above everything, doors are drawn as openings.
_NOT_DRAWN: Final = frozenset({"door", "room_light", "downlight"})


def plan_of(house: House) -> dict[str, Any]:
    """The plan of a home, in metres in the world frame.

    Args:
        house: the compiled home.

    Returns:
        ``bounds`` (x0, y0, x1, y1), ``rooms`` (``name``, ``type``, ``rect``, ``outdoor``), ``openings`` (axis, coord,
        lo, hi) and ``things``, one per item of the home, in the home's order: ``category``, and ``box`` (x0, y0, x1,
        y1), null where it is not drawn.
    """
    x, y = house.grid.origin_xy
    nx, ny = house.grid.shape
    things = [
        {"category": item.category, "box": None if item.category in _NOT_DRAWN else footprint(house.boxes[k])}
        for k, item in enumerate(house.spec.items)
    ]
    return {
        "name": house.spec.name,
        "bounds": [x, y, x + nx * GRID_M, y + ny * GRID_M],
        "rooms": [
            {"name": r.name, "type": r.type, "rect": list(r.rect), "outdoor": r.outdoor} for r in house.spec.rooms
        ],
        "openings": [[o.axis, o.coord, o.lo, o.hi] for o in house.spec.openings],
        "things": things,
    }


def footprint(box: NDArray[np.float64]) -> list[float] | None:
    """x0, y0, x1, y1 of a box, to the centimetre; None for a thing that is nowhere, whose box is not finite.

    Args:
        box: (6,) x0 y0 z0 x1 y1 z1, metres.
    """
    if not np.isfinite(box).all():
        return None
    return [round(float(box[k]), 2) for k in (0, 1, 3, 4)]


def placed_in(arrangement: Arrangement, boxes: NDArray[np.float64], n_instances: int) -> dict[str, Any]:
    """The things that an episode removes from a home and those that it places in it.

    Args:
        arrangement: what was removed and placed.
        boxes: (n, 6) boxes of all instances, metres; the placed objects are the last ones.
        n_instances: number of the home's own instances.

    Returns:
        ``removed``: indices of ``things`` of the plan; ``objects``: ``category`` and ``box`` of what was placed.
    """
    objects = [
        {"category": placed.category, "box": footprint(boxes[n_instances + k])}
        for k, placed in enumerate(arrangement.objects)
    ]
    return {"removed": list(arrangement.removed), "objects": objects}
