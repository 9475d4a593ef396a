"""The small top-down map beside the first-person frame. For people: it shows what the agent cannot know."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import GRID_M
from ucon.sim.house import House
from ucon.task.actions import AHEAD

Image = NDArray[np.uint8]

_FREE, _OUTSIDE, _BLOCKED = (238, 236, 230), (58, 62, 70), (196, 190, 180)
_WALL, _HEDGE = (84, 80, 76), (70, 110, 64)
_PATH, _AGENT, _TARGET, _OPENED = (64, 110, 190), (24, 60, 140), (214, 60, 48), (226, 160, 60)


class TopDownMap:
    """Draws one home from above with the search in it; x to the right, y up."""

    def __init__(self, house: House, boxes: NDArray[np.float64], free: NDArray[np.bool_], size_px: int) -> None:
        self._origin = house.grid.origin_xy
        nx, ny = house.grid.shape
        self._scale = size_px / (max(nx, ny) * GRID_M)
        self._size = size_px
        self._height_m = ny * GRID_M
        self._margin = (
            (size_px - nx * GRID_M * self._scale) / 2,
            (size_px - ny * GRID_M * self._scale) / 2,
        )
        base = np.full((size_px, size_px, 3), _OUTSIDE, np.uint8)
        for i, j in np.argwhere(house.grid.room >= 0):
            color = _FREE if free[i, j] else _BLOCKED
            corner = self._px(self._origin[0] + i * GRID_M, self._origin[1] + (j + 1) * GRID_M)
            other = self._px(self._origin[0] + (i + 1) * GRID_M, self._origin[1] + j * GRID_M)
            cv2.rectangle(base, corner, other, color, -1)
        for k, item in enumerate(house.spec.items):
            box = boxes[k]
            if np.isfinite(box).all() and box[5] > 0.1 and item.category not in ("door", "room_light"):
                cv2.rectangle(base, self._px(box[0], box[4]), self._px(box[3], box[1]), (150, 138, 120), 1)
        self._draw_walls(base, house)
        self._base = base

    def draw(
        self,
        path_xy: list[tuple[float, float]],
        heading: int,
        target_box: NDArray[np.float64],
        opened: NDArray[np.float64],
    ) -> Image:
        """The map with path, agent, target and opened boxes (m, 6); (size, size, 3) uint8."""
        image = self._base.copy()
        for box in opened:
            cv2.rectangle(image, self._px(box[0], box[4]), self._px(box[3], box[1]), _OPENED, -1)
        points = np.array([self._px(*p) for p in path_xy], np.int32)
        if len(points) > 1:
            cv2.polylines(image, [points], False, _PATH, 2, cv2.LINE_AA)
        center = self._px((target_box[0] + target_box[3]) / 2, (target_box[1] + target_box[4]) / 2)
        cv2.drawMarker(image, center, _TARGET, cv2.MARKER_TILTED_CROSS, 12, 3)
        x, y = path_xy[-1]
        ahead = AHEAD[heading]
        tip = self._px(x + 0.45 * ahead[0], y + 0.45 * ahead[1])
        cv2.circle(image, self._px(x, y), max(3, int(0.18 * self._scale)), _AGENT, -1, cv2.LINE_AA)
        cv2.line(image, self._px(x, y), tip, _AGENT, 2, cv2.LINE_AA)
        return image

    def _draw_walls(self, image: Image, house: House) -> None:
        wide = max(1, round(0.12 * self._scale))
        for room in house.spec.rooms:
            x0, y0, x1, y1 = room.rect
            cv2.rectangle(image, self._px(x0, y1), self._px(x1, y0), _HEDGE if room.outdoor else _WALL, wide)
        for hole in house.spec.openings:
            ends = [(hole.coord, at) if hole.axis == 0 else (at, hole.coord) for at in (hole.lo, hole.hi)]
            cv2.line(image, self._px(*ends[0]), self._px(*ends[1]), _FREE, wide + 1)

    def _px(self, x: float, y: float) -> tuple[int, int]:
        u = self._margin[0] + (x - self._origin[0]) * self._scale
        v = self._margin[1] + (self._height_m - (y - self._origin[1])) * self._scale
        return round(float(u)), round(float(v))
