"""When each place was last looked at: a place that was empty then holds a thing only if somebody put it there since.

For every place where a thing can be, the robot notes when it last looked at it, and from how near: a look that is near
enough to show a book is not near enough to show a key.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ucon.perception.belief.recalled import nearest, points_of
from ucon.perception.mapping.map_kernels import look_from
from ucon.perception.mapping.semantic_map import SemanticMap, camera_of
from ucon.perception.places.containers import Containers
from ucon.perception.places.target_places import Places

#: Distances from which things are recognised, metres; a look counts for each distance that it came within.
REACHES_M: Final = (1.2, 1.6, 2.1, 2.8, 3.6, 4.5)
#: Never looked at.
NEVER: Final = -1


class Looking:
    """Tracks where one robot has looked."""

    def __init__(self) -> None:
        """Start with nothing looked at."""
        self._points, self._when = np.zeros((0, 4)), np.zeros((0, len(REACHES_M)), np.int64)
        self._places, self._near = Places(0.1), np.zeros(0)
        self._containers = Containers()

    def begin(self, reach_m: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Begin a request.

        Args:
            reach_m: from how far the target is recognised, metres.

        Returns:
            Points (m, 4) in the form of :func:`ucon.perception.belief.recalled.points_of`, and times (m,) of the last
            looks that would have shown the target there; :data:`NEVER` where there was none.
        """
        self._places, self._near, self._containers = Places(0.1), np.zeros(0), Containers()
        enough = [k for k, reach in enumerate(REACHES_M) if reach <= reach_m + 1e-6]
        return self._points, self._when[:, enough].max(1, initial=NEVER)

    def look(self, known: SemanticMap, depth: NDArray[np.float32]) -> None:
        """Take in a frame.

        Args:
            known: the map, updated with the frame.
            depth: (H, W), metres.
        """
        places = self._places
        places.refresh(known)
        if len(places.xyz) > len(self._near):
            self._near = np.append(self._near, np.full(len(places.xyz) - len(self._near), np.inf))
        shut = np.zeros(known.n_tracks, bool)
        shut[self._containers.closed(known)] = True
        active, camera = places.searched(shut), camera_of(known.view, depth, known.body)
        look_from(depth, camera, places.xyz, places.hollow, places.faces, active, self._near)

    def end(self, time: int) -> None:
        """Note what the request showed.

        Args:
            time: time of the request.
        """
        now = np.flatnonzero(self._places.even > 0.0)
        points = points_of(self._places)[now]
        when = _carried(self._points, self._when, points)
        shown = self._near[now, None] <= np.array(REACHES_M)
        self._points, self._when = points, np.where(shown, time, when)


def _carried(points: NDArray[np.float64], when: NDArray[np.int64], to: NDArray[np.float64]) -> NDArray[np.int64]:
    """Times (n, R) for the points ``to``, taken from the earlier points at the same positions; NEVER without one."""
    row, same = nearest(cKDTree(points) if len(points) else None, to)
    found = np.full((len(to), when.shape[1]), NEVER, np.int64)
    found[same] = when[row[same]]
    return found
