"""The map around the agent as a small image, in which a network sees rooms, walls and unexplored space.

The agent is in the middle and looks along the first axis; left is along the second, as in the positions of tokens. A
pixel stands for half a metre: 3 x 3 cells of the map with binomial weights, so that a mirrored home gives a mirrored
image.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F32, jit
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SIZE, SemanticMap, View
from ucon.perception.places.affordances import affordance
from ucon.perception.places.neighbourhood import room_numbers, rooms_of
from ucon.perception.views.viewpoints import Viewpoints
from ucon.search.view_tokens import log_scale, to_agent_frame

#: Pixels of a side.
SIDE: Final = 41
#: Cells between the middles of pixels.
STRIDE: Final = 2
#: Cells of the side that the pixels cover.
_WINDOW: Final = STRIDE * (SIDE - 1) + 3
#: Metres between the middles of pixels.
PIXEL_M: Final = STRIDE * CELL_M
#: Kinds of rooms with a channel each, in which their furniture is marked; most furniture is in one of these.
ROOMS: Final = ("bathroom", "bedroom", "kitchen", "living_room", "dining_room", "corridor", "garage", "garden")
_MAP: Final = ("explored", "floor", "height", "walls", "blocked", "near", "visited", "stale", "interest", "mass")
_MASS: Final = len(_MAP) - 1
#: What each channel shows.
CHANNELS: Final = (*_MAP, *ROOMS)
#: Heights of obstacles are distinguished up to this one, metres.
_TALL_M: Final = 1.9


def map_raster(
    known: SemanticMap,
    viewpoints: Viewpoints,
    xyz: NDArray[np.float64],
    weight: NDArray[np.float64],
    interest: NDArray[np.float32] | None,
) -> NDArray[np.uint8]:
    """The map around the agent.

    Args:
        known: the map.
        viewpoints: from how far away the target is recognised, and where views showed nothing new.
        xyz: (n, 3) sample points, metres.
        weight: (n,) their mass.
        interest: (257, 257) factors of the worth of unexplored cells; None: all 1.

    Returns:
        (C, 41, 41) uint8 for the channels of :data:`CHANNELS`; 255 stands for 1.
    """
    view = known.view
    spots = np.zeros((1 + len(ROOMS), _WINDOW, _WINDOW), np.float32)
    _mark(spots[:1], xyz[:, :2], weight[:, None], view)
    tracks, rooms = _furniture(known)
    if len(tracks):
        box = known.box[tracks]
        _mark(spots[1:], 0.5 * (box[:, :2] + box[:, 3:5]), rooms, view)
    out = np.zeros((len(CHANNELS), SIDE, SIDE), np.float32)
    factors = np.ones((SIZE, SIZE), np.float32) if interest is None else interest
    seen = (known.explored, known.floor, known.height, known.walls, known.blocked, known.near, known.visited)
    _draw((view.i, view.j, view.quarter), (*seen, viewpoints.stale, factors), spots, viewpoints.reach_m, out)
    out[_MASS] = log_scale(out[_MASS])
    return np.asarray(np.clip(out, 0.0, 1.0) * 255.0 + 0.5, np.uint8)


def _furniture(known: SemanticMap) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Tracks (n,) of the furniture seen, and the share of each of ``ROOMS`` among its rooms (n, R)."""
    shares = _shares()
    seen = [(track, shares[name]) for name, tracks in known.instances.items() if name in shares for track in tracks]
    seen = [(track, share) for track, share in seen if known.seen(track)]
    return np.array([track for track, _ in seen], np.int64), np.array([share for _, share in seen], np.float32)


def _mark(spots: F32, xy: NDArray[np.float64], values: NDArray[Any], view: View) -> None:
    """Add values (n, C) of points (n, 2), metres, to the cells around the agent, (C, W, W)."""
    cells = np.floor(xy / CELL_M + 0.5).astype(np.int64) + HALF - np.array([view.i, view.j])
    at = np.rint(to_agent_frame(cells, view)).astype(np.int64) + _WINDOW // 2
    inside = ((at >= 0) & (at < _WINDOW)).all(1)
    np.add.at(spots, (slice(None), *at[inside].T), values[inside].T)


@lru_cache(maxsize=1)
def _shares() -> dict[str, NDArray[np.float64]]:
    """Share (R,) of each of ``ROOMS`` among the rooms of a category, by name, for all furniture."""
    book, number = catalogue(), room_numbers()
    columns = [number[room] for room in ROOMS]
    return {
        name: rooms_of(name)[columns]
        for name in book.names
        if affordance(name).furniture and any(room in number for room in book[name].rooms)
    }


@jit
def _draw(pose: tuple[int, int, int], cells: Any, spots: F32, reach_m: float, out: F32) -> None:
    """Write the channels: means of grids, and sums of ``spots``."""
    explored, floor, height, walls, blocked, near, visited, stale, interest = cells
    i0, j0, heading = pose
    ci, si = (1, 0, -1, 0)[heading], (0, 1, 0, -1)[heading]
    half = out.shape[1] // 2
    first, middle = out.shape[0] - spots.shape[0], spots.shape[1] // 2
    size = explored.shape[0]
    for a in range(out.shape[1]):
        for b in range(out.shape[2]):
            for da in range(-1, 2):
                for db in range(-1, 2):
                    ahead, left = STRIDE * (a - half) + da, STRIDE * (b - half) + db
                    i, j = i0 + ci * ahead - si * left, j0 + si * ahead + ci * left
                    if i < 1 or j < 1 or i >= size - 1 or j >= size - 1:
                        continue
                    w = (2 - abs(da)) * (2 - abs(db)) / 16.0
                    wall = walls[0, i, j] + walls[0, i - 1, j] + walls[1, i, j] + walls[1, i, j - 1]
                    out[0, a, b] += w * explored[i, j]
                    out[1, a, b] += w * floor[i, j]
                    out[2, a, b] += w * min(max(height[i, j], 0.0) / _TALL_M, 1.0)
                    out[3, a, b] += w * (wall > 0)
                    out[4, a, b] += w * blocked[i, j]
                    out[5, a, b] += w * (near[i, j] <= reach_m)
                    out[6, a, b] += w * visited[i, j]
                    out[7, a, b] += w * stale[i, j]
                    out[8, a, b] += w * min(0.25 * interest[i, j], 1.0)
                    for k in range(spots.shape[0]):
                        out[first + k, a, b] += w * spots[k, ahead + middle, left + middle]
