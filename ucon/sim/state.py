"""The compiled state of an episode: the same answers as :class:`World`, from arrays and without PyBullet."""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.core.sharing import PartlyShared
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.shapes import item_solid, object_box, object_solid

_openable_items: WeakKeyDictionary[House, NDArray[np.bool_]] = WeakKeyDictionary()


class SceneState(PartlyShared):
    """A home with one arrangement: which instances are there, where they are, which are open, which nodes are free.

    Instances are numbered as in :class:`House`, objects of the arrangement last. Arrays have one row per instance.

    Attributes:
        house: the compiled home, shared and read-only.
        arrangement: what the episode changed.
        categories: category of every instance.
        boxes: (n, 6) closed boxes in world metres.
        room: (n,) int16.
        removed: (n,) bool, instances of the home that were removed.
        openable: (n,) bool, present instances with joints.
        open: (n,) bool; the only attribute that changes during an episode.
        free: (nx, ny) bool, the grid's free nodes without those that objects on the floor block.
    """

    _shared: ClassVar[frozenset[str]] = frozenset(
        {"house", "arrangement", "categories", "boxes", "room", "removed", "openable", "free"}
    )

    def __init__(self, house: House, arrangement: Arrangement | None = None) -> None:
        self.house = house
        self.arrangement = arrangement or Arrangement()
        objects = self.arrangement.objects
        n = house.n_instances + len(objects)
        self.categories = house.categories + tuple(placed.category for placed in objects)
        self.boxes = arrangement_boxes(house, self.arrangement)
        self.room = np.concatenate([house.instance_room, np.array([placed.room for placed in objects], np.int16)])
        self.removed = np.zeros(n, bool)
        self.removed[list(_checked_removed(house, self.arrangement))] = True
        self.openable = np.zeros(n, bool)
        self.openable[: house.n_instances] = _openables(house)
        self.openable[house.n_instances :] = [object_solid(placed).model.openable for placed in objects]
        self.openable &= ~self.removed
        self.open = np.zeros(n, bool)
        self.free = house.grid.free.copy()
        if self.arrangement.blocked:
            blocked = np.array(self.arrangement.blocked)
            self.free[blocked[:, 0], blocked[:, 1]] = False

    @property
    def n_instances(self) -> int:
        """Number of instances, removed ones included."""
        return len(self.categories)

    def set_open(self, instance: int, is_open: bool = True) -> None:
        """Open or close an instance.

        Raises:
            EpisodeError: it has no joint, or was removed.
        """
        if not self.openable[instance]:
            raise EpisodeError(f"instance {instance} ({self.categories[instance]}) cannot be opened")
        self.open[instance] = is_open

    def instances_of(self, category: str) -> list[int]:
        """Present instances of a category, ascending."""
        return [i for i, name in enumerate(self.categories) if name == category and not self.removed[i]]

    def horizontal_distance(self, x: float, y: float) -> NDArray[np.float64]:
        """Horizontal distance from a point to every box.

        Args:
            x: world metres.
            y: world metres.

        Returns:
            (n,) metres.
        """
        gx = np.maximum(np.maximum(self.boxes[:, 0] - x, x - self.boxes[:, 3]), 0.0)
        gy = np.maximum(np.maximum(self.boxes[:, 1] - y, y - self.boxes[:, 4]), 0.0)
        return np.hypot(gx, gy)


def arrangement_boxes(house: House, arrangement: Arrangement) -> NDArray[np.float64]:
    """Closed boxes (n, 6) of all instances of a home and the objects of an arrangement, world metres."""
    if not arrangement.objects:
        return house.boxes.copy()
    return np.concatenate([house.boxes, np.array([placed_box(placed) for placed in arrangement.objects])])


@lru_cache(maxsize=65536)
def placed_box(placed: PlacedObject) -> tuple[float, ...]:
    """Closed box of a placed object as a tuple of 6, world metres; cached, since episodes are replayed many times."""
    return tuple(object_box(placed).tolist())


def _checked_removed(house: House, arrangement: Arrangement) -> tuple[int, ...]:
    wrong = [i for i in arrangement.removed if not 0 <= i < house.n_items]
    if wrong:
        raise EpisodeError(
            f"{house.spec.name}: an arrangement removes instance {wrong[0]}, but only its items 0 to "
            f"{house.n_items - 1} can be removed; the episode belongs to another version of this home"
        )
    return arrangement.removed


def _openables(house: House) -> NDArray[np.bool_]:
    if house not in _openable_items:
        flags = np.zeros(house.n_instances, bool)
        flags[: house.n_items] = [item_solid(item).model.openable for item in house.spec.items]
        _openable_items[house] = flags
    return _openable_items[house]
