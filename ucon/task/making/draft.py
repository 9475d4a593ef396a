"""An arrangement under construction, and which categories and instances can be used next."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from ucon.objects import catalogue
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.placement import with_object


@dataclass
class Draft:
    """An arrangement under construction.

    Attributes:
        house: the home.
        arrangement: what was removed and placed so far.
        origins: for each placed object, entry id and index of its placement; ("", -1) for added anchors.
        failures: placements that failed, as text.
    """

    house: House
    arrangement: Arrangement
    origins: list[tuple[str, int]] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @property
    def objects(self) -> tuple[PlacedObject, ...]:
        """The objects placed so far."""
        return self.arrangement.objects

    def remove(self, instances: Iterable[int]) -> None:
        """Remove items of the home, by instance."""
        removed = tuple(sorted({*self.arrangement.removed, *instances}))
        self.arrangement = replace(self.arrangement, removed=removed)

    def add(self, placed: PlacedObject, origin: tuple[str, int]) -> None:
        """Add an object; its pose is rounded to 6 decimals, as it will be stored.

        Args:
            placed: the object.
            origin: entry id and index of its placement.
        """
        self.arrangement = with_object(self.house, self.arrangement, rounded(placed))
        self.origins.append(origin)


def rounded(placed: PlacedObject) -> PlacedObject:
    """The object with its pose rounded to 6 decimals, as it is stored."""
    x, y, z = (round(v, 6) + 0.0 for v in placed.position)
    a, b, c, d = (round(v, 6) + 0.0 for v in placed.quat_xyzw)
    return replace(placed, position=(x, y, z), quat_xyzw=(a, b, c, d))


def instances_of(house: House, names: Iterable[str]) -> tuple[int, ...]:
    """Instances of the home whose category is among ``names``."""
    wanted = set(names)
    return tuple(k for k, item in enumerate(house.spec.items) if item.category in wanted)


def replacement(house: House, waiting: Sequence[str], draft: Draft) -> str | None:
    """The next waiting category that is not placed yet and is not the anchor or holder of a placed object.

    Args:
        house: the home.
        waiting: categories in order.
        draft: the arrangement so far.

    Returns:
        The category; None if there is none.
    """
    used = {o.anchor for o in draft.objects} | {o.holder for o in draft.objects}
    taken = {o.category for o in draft.objects} | {house.categories[k] for k in used if 0 <= k < house.n_instances}
    return next((name for name in waiting if name not in taken), None)


def anchor_instances(house: House, draft: Draft, category: str) -> list[int]:
    """Instances of a category in the draft: those of the home that were not removed, and those already placed."""
    removed = set(draft.arrangement.removed)
    base = [k for k, name in enumerate(house.categories) if name == category and k not in removed]
    added = [house.n_instances + k for k, o in enumerate(draft.objects) if o.category == category]
    return base + added


def room_of(house: House, draft: Draft, instance: int) -> int:
    """Number of the room of an instance of the home, or of a placed object."""
    n = house.n_instances
    return int(house.instance_room[instance]) if instance < n else draft.objects[instance - n].room


def bearing_categories(house: House) -> set[str]:
    """Categories that other items of the home stand on, and the structure; none of them is ever removed."""
    boxes, items = house.boxes[: house.n_items], house.spec.items
    bearing = {"walls", "floors", "ceilings"}
    for below, above in itertools.permutations(range(len(items)), 2):
        if items[above].position[2] < 0.02 or catalogue()[items[above].category].mount in ("wall", "ceiling"):
            continue
        a, b = boxes[below], boxes[above]
        center = (b[:2] + b[3:5]) / 2
        inside = (a[:2] <= center).all() and (center <= a[3:5]).all()
        if inside and a[2] <= items[above].position[2] <= a[5] + 0.02:
            bearing.add(items[below].category)
    return bearing
