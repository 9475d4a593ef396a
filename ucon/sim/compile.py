"""Compiles the specification of a home into a :class:`House`: PyBullet builds it once and checks it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ucon.core.errors import SceneError
from ucon.objects.catalogue import catalogue
from ucon.scenes.spec import HomeSpec
from ucon.sim.checks import HomeProblem, hidden, overlaps, sweeps
from ucon.sim.house import House
from ucon.sim.navgrid import nav_grid
from ucon.sim.shapes import Array, enclosing, item_box, primitive_boxes, solid_of_parts
from ucon.sim.structure import structure_parts
from ucon.sim.world import World

#: Most rounds in which :func:`compile_mended` removes things.
MENDING_ROUNDS = 4


def compile_house(spec: HomeSpec, *, check: bool = True) -> House:
    """Build a home in PyBullet, check it and return what episodes need.

    Args:
        spec: the home.
        check: False skips the checks for faults.

    Raises:
        SceneError: items overlap by more than 5 mm, a joint hits something, an openable cannot be seen into, or the
            free floor is not in one piece. The message names the items.
    """
    house, problems = _build(spec, check)
    if problems:
        raise SceneError(_message(spec, problems))
    return house


def compile_mended(spec: HomeSpec) -> House:
    """As :func:`compile_house`, but movable things with faults are removed from the home.

    Generated homes are made by rules that look at boxes alone. Where PyBullet finds that a microwave's door hits a
    bowl, the bowl is removed. The 22 named scenes need no removal (tested).

    Raises:
        SceneError: furniture has a fault, or faults remain after a few rounds.
    """
    for _ in range(MENDING_ROUNDS):
        house, problems = _build(spec, check=True)
        if not problems:
            return house
        refused = {_smaller(spec, problem) for problem in problems}
        if -1 in refused:
            raise SceneError(_message(spec, problems))
        refused |= {k for k in range(len(spec.items)) for other in refused if _stands_on(spec, k, other)}
        items = tuple(item for k, item in enumerate(spec.items) if k not in refused)
        spec = replace(spec, items=items)
    return compile_house(spec)


def _build(spec: HomeSpec, check: bool) -> tuple[House, list[HomeProblem]]:
    with World(spec) as world:
        grid = nav_grid(world)
        problems = [*overlaps(world), *sweeps(world), *hidden(world, grid)] if check else []
        return House(spec, grid, all_boxes(spec)), problems


def _smaller(spec: HomeSpec, problem: HomeProblem) -> int:
    """The movable item of a problem, the smaller of two; -1 where there is none."""
    involved = {k for k in (problem.instance, problem.other) if 0 <= k < len(spec.items)}
    loose = [k for k in involved if catalogue()[spec.items[k].category].role in ("movable", "movable_furniture")]
    return min(loose, key=lambda k: (float(np.prod(spec.items[k].size)), k), default=-1)


def _stands_on(spec: HomeSpec, above: int, below: int) -> bool:
    a, b = item_box(spec.items[above]), item_box(spec.items[below])
    center = (a[:2] + a[3:5]) / 2
    return above != below and bool((b[:2] <= center).all() and (center <= b[3:5]).all() and abs(a[2] - b[5]) < 0.02)


def all_boxes(spec: HomeSpec) -> Array:
    """Boxes of all instances with joints closed.

    Returns:
        (n, 6) x0 y0 z0 x1 y1 z1 in world metres; zeros for structure that has no part.
    """
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


def _message(spec: HomeSpec, problems: list[HomeProblem]) -> str:
    shown = "; ".join(problem.text for problem in problems[:3])
    more = f"; and {len(problems) - 3} more" if len(problems) > 3 else ""
    return f"{spec.name}: {shown}{more}; move or resize the items"
