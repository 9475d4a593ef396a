"""From the specification of a home to a compiled :class:`House`: PyBullet builds it once and checks it."""

from __future__ import annotations

import numpy as np

from ucon.core.errors import SceneError
from ucon.scenes.spec import HomeSpec
from ucon.sim.checks import Problem, hidden, overlaps, sweeps
from ucon.sim.house import House
from ucon.sim.navgrid import nav_grid
from ucon.sim.shapes import Array, enclosing, item_box, primitive_boxes, solid_of_parts
from ucon.sim.structure import structure_parts
from ucon.sim.world import World


def compile_house(spec: HomeSpec, *, check: bool = True) -> House:
    """Build a home in PyBullet, check it and return what episodes need.

    Raises:
        SceneError: items overlap by more than 5 mm, a joint hits something, the inside of an openable cannot be
            seen, or the free floor falls into pieces. The message names the items.
    """
    with World(spec) as world:
        grid = nav_grid(world)
        house = House(spec, grid, all_boxes(spec))
        problems = [*overlaps(world), *sweeps(world), *hidden(world, grid)] if check else []
    if problems:
        raise SceneError(_message(spec, problems))
    return house


def inspect_home(spec: HomeSpec) -> list[Problem]:
    """Everything that :func:`compile_house` would refuse, as a list; free floor in pieces still raises."""
    with World(spec) as world:
        grid = nav_grid(world)
        return [*overlaps(world), *sweeps(world), *hidden(world, grid)]


def all_boxes(spec: HomeSpec) -> Array:
    """World boxes (n, 6) of all instances with joints closed; zeros for structure that has no part."""
    boxes = np.zeros((len(spec.items) + 3 * len(spec.rooms), 6))
    for number, item in enumerate(spec.items):
        boxes[number] = item_box(item)
    kinds = {"floors": 0, "walls": 1, "ceilings": 2}
    for room, kind, parts in structure_parts(spec):
        if parts:
            shape = solid_of_parts(parts)
            boxes[len(spec.items) + 3 * room + kinds[kind]] = enclosing(
                primitive_boxes(shape, (0.0, 0.0, 0.0), np.eye(3))
            )
    return boxes


def _message(spec: HomeSpec, problems: list[Problem]) -> str:
    shown = "; ".join(problem.text for problem in problems[:3])
    more = f"; and {len(problems) - 3} more" if len(problems) > 3 else ""
    return f"{spec.name}: {shown}{more}; move or resize the items"
