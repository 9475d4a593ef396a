"""Where things were seen, and where looks did not find them: the facts that a robot keeps about its home.

A thing's places are points in the frame of the dock; sightings within :data:`SAME_M` belong to one place. Times count
slots, see :func:`ucon.lives.clock.time_of`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ucon.objects.model import Spot

#: Sightings of a thing this close together belong to one place, metres.
SAME_M = 0.4


@dataclass
class SeenThing:
    """What is known about one thing.

    Attributes:
        name: category.
        places: (n, 3) points, metres; one for each place where it was seen.
        seen: (time, place) of each request in which it was seen, in order of time.
        absent: (time, place) of each request that showed a place without the thing.
        spots: relations and anchors of each place, as last named; () where nothing was near.
        size: (n, 3) sides of what was last seen at each place, metres; 0 where not known.
    """

    name: str
    places: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    seen: list[tuple[int, int]] = field(default_factory=list)
    absent: list[tuple[int, int]] = field(default_factory=list)
    spots: list[Spot] = field(default_factory=list)
    size: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def place_at(self, xyz: NDArray[np.float64]) -> int:
        """Number of the place at a point; adds a new place if the thing was never seen near there."""
        if len(self.places):
            away = np.linalg.norm(self.places - xyz, axis=1)
            if away.min() <= SAME_M:
                return int(away.argmin())
        self.places, self.size = np.vstack([self.places, xyz]), np.vstack([self.size, np.zeros(3)])
        self.spots.append(())
        return len(self.places) - 1


class SightingLog:
    """The sightings of all things in one home."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self.things: dict[str, SeenThing] = {}

    def last(self) -> int:
        """Time of the newest entry; -1 without any."""
        entries = [entry for thing in self.things.values() for entry in (*thing.seen, *thing.absent)]
        return max((time for time, _ in entries), default=-1)

    def saw(
        self, name: str, xyz: NDArray[np.float64], time: int, spot: Spot = (), size: NDArray[np.float64] | None = None
    ) -> None:
        """Note where a thing was last seen in a request.

        Args:
            name: category.
            xyz: (3,) centre of the part of it that was seen, metres in the frame of the dock.
            time: time of the request.
            spot: relations and anchors of the place; () if not known.
            size: (3,) sides of the part of it that was seen, metres; None if they do not matter.
        """
        thing = self.things.setdefault(name, SeenThing(name))
        place = thing.place_at(xyz)
        thing.seen.append((time, place))
        thing.spots[place] = spot or thing.spots[place]
        if size is not None:
            thing.size[place] = size

    def saw_again(self, name: str, place: int, time: int) -> None:
        """Note that a thing is still at a known place.

        Args:
            name: category.
            place: number of the place.
            time: time of the request.
        """
        self.things[name].seen.append((time, place))

    def missed(self, name: str, place: int, time: int) -> None:
        """Note that a request showed a place of a thing without the thing.

        Args:
            name: category.
            place: number of the place.
            time: time of the request.
        """
        self.things[name].absent.append((time, place))
