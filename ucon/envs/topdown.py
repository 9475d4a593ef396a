"""The top-down map beside the camera's image, for people only: it shows privileged facts."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.scenes.spec import GRID_M
from ucon.sim.house import House
from ucon.sim.render.base import heading_cos_sin

Image = NDArray[np.uint8]
Color = tuple[int, int, int]

_FREE, _OUTSIDE, _BLOCKED, _EDGE = (238, 236, 230), (58, 62, 70), (196, 190, 180), (150, 138, 120)
_WALL, _HEDGE, _NAME = (84, 80, 76), (70, 110, 64), (120, 112, 100)
_PATH, _AGENT, _TARGET, _OPENED, _START = (64, 110, 190), (24, 60, 140), (214, 60, 48), (226, 160, 60), (60, 140, 80)
_LEGEND_PX, _LEGEND_INK = 18, (225, 225, 225)
#: Margin around the home.
_EDGE_PX = 10
_FONT, _FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.34


class TopDownMap:
    """Draws one home from above with the search in it, in the orientation of the agent's own map.

    The agent's first heading points to the right, so that both maps of a film can be compared.
    """

    def __init__(
        self, house: House, boxes: NDArray[np.float64], free: NDArray[np.bool_], size_px: int, heading: int = 0
    ) -> None:
        """Draw the home.

        Args:
            house: the home.
            boxes: (n, 6) boxes of its things, metres.
            free: (nx, ny) nodes where the agent can stand.
            size_px: side of the picture.
            heading: heading of the agent at the start, quarter turns.
        """
        self._size, self._turned = size_px, (HEADING_COS[heading], HEADING_SIN[heading])
        x, y = house.grid.origin_xy
        nx, ny = house.grid.shape
        corners = np.array([self._ahead_left(x, y), self._ahead_left(x + nx * GRID_M, y + ny * GRID_M)])
        low, high = corners.min(0), corners.max(0)
        room = np.array([size_px, size_px - _LEGEND_PX])
        self._scale = float(((room - 2 * _EDGE_PX) / (high - low)).min())
        self._low, self._high = low, high
        self._margin = (room - (high - low) * self._scale) / 2
        self._base = np.full((size_px, size_px, 3), _OUTSIDE, np.uint8)
        for i, j in np.argwhere(house.grid.room >= 0):
            corner = (x + i * GRID_M, y + j * GRID_M, x + (i + 1) * GRID_M, y + (j + 1) * GRID_M)
            self._rectangle(self._base, corner, _FREE if free[i, j] else _BLOCKED, -1)
        for k, item in enumerate(house.spec.items):
            box = boxes[k]
            if np.isfinite(box).all() and box[5] > 0.1 and item.category not in ("door", "room_light"):
                self._rectangle(self._base, (box[0], box[1], box[3], box[4]), _EDGE, 1)
        self._draw_walls(house)
        self._draw_names(house)
        self._draw_legend()

    def draw(
        self,
        path_xy: Sequence[tuple[float, float]],
        heading: float,
        target_box: NDArray[np.float64],
        opened: NDArray[np.float64],
    ) -> Image:
        """Draw the state of a search; all coordinates are in the world frame.

        Args:
            path_xy: nodes of the path so far, metres.
            heading: heading of the agent, quarter turns.
            target_box: (6,) box of the target, metres.
            opened: (m, 6) boxes of opened containers, metres.

        Returns:
            (size_px, size_px, 3) uint8.
        """
        image = self._base.copy()
        for box in opened:
            self._rectangle(image, (box[0], box[1], box[3], box[4]), _OPENED, -1)
        points = np.array([self._px(*p) for p in path_xy], np.int32)
        if len(points) > 1:
            cv2.polylines(image, [points], False, _PATH, 2, cv2.LINE_AA)
        cv2.circle(image, self._px(*path_xy[0]), 4, _START, 2, cv2.LINE_AA)
        _star(image, self._px(*(target_box[:2] + target_box[3:5]) / 2), 9)
        (x, y), (c, s) = path_xy[-1], heading_cos_sin(heading)
        tip = self._px(x + 0.45 * c, y + 0.45 * s)
        cv2.circle(image, self._px(x, y), max(3, int(0.18 * self._scale)), _AGENT, -1, cv2.LINE_AA)
        cv2.line(image, self._px(x, y), tip, _AGENT, 2, cv2.LINE_AA)
        return image

    def _draw_walls(self, house: House) -> None:
        """Draw walls and the openings in them."""
        wide = max(1, round(0.12 * self._scale))
        for room in house.spec.rooms:
            self._rectangle(self._base, room.rect, _HEDGE if room.outdoor else _WALL, wide)
        for hole in house.spec.openings:
            ends = [(hole.coord, at) if hole.axis == 0 else (at, hole.coord) for at in (hole.lo, hole.hi)]
            cv2.line(self._base, self._px(*ends[0]), self._px(*ends[1]), _FREE, wide + 1)

    def _draw_names(self, house: House) -> None:
        """Write each room's type if it fits into the room."""
        for room in house.spec.rooms:
            x0, y0, x1, y1 = room.rect
            (u0, v0), (u1, v1) = self._px(x0, y0), self._px(x1, y1)
            text = room.type.replace("_", " ")
            (wide, high), _ = cv2.getTextSize(text, _FONT, _FONT_SCALE, 1)
            if wide < abs(u1 - u0) - 6 and high < abs(v1 - v0) - 6:
                at = ((u0 + u1 - wide) // 2, (v0 + v1 + high) // 2)
                cv2.putText(self._base, text, at, _FONT, _FONT_SCALE, _NAME, 1, cv2.LINE_AA)

    def _draw_legend(self) -> None:
        """Draw the legend."""
        v, text_v, step = self._size - _LEGEND_PX // 2, self._size - 5, self._size // 4
        for k, text in enumerate(("target", "start", "agent", "opened")):
            u = k * step + 14
            cv2.putText(self._base, text, (u + 11, text_v), _FONT, _FONT_SCALE, _LEGEND_INK, 1, cv2.LINE_AA)
            if text == "target":
                _star(self._base, (u, v), 6)
            elif text == "opened":
                cv2.rectangle(self._base, (u - 4, v - 4), (u + 4, v + 4), _OPENED, -1)
            else:
                filled = text == "agent"
                cv2.circle(self._base, (u, v), 4, _AGENT if filled else _START, -1 if filled else 2, cv2.LINE_AA)

    def _rectangle(self, image: Image, corners: Sequence[float], color: Color, thickness: int) -> None:
        """Draw a rectangle; ``corners``: x0, y0, x1, y1 in world metres; a thickness of -1 fills it."""
        cv2.rectangle(image, self._px(*corners[:2]), self._px(*corners[2:]), color, thickness)

    def _ahead_left(self, x: float, y: float) -> tuple[float, float]:
        """World coordinates along the agent's first heading and to its left."""
        c, s = self._turned
        return c * x + s * y, c * y - s * x

    def _px(self, x: float, y: float) -> tuple[int, int]:
        """Column and row of a world point."""
        ahead, left = self._ahead_left(x, y)
        u = self._margin[0] + (ahead - self._low[0]) * self._scale
        v = self._margin[1] + (self._high[1] - left) * self._scale
        return round(float(u)), round(float(v))


def _star(image: Image, at: tuple[int, int], radius: int) -> None:
    """A five-pointed star with a light edge, visible on any background."""
    turn = np.pi * np.arange(10) / 5
    reach = np.where(np.arange(10) % 2 == 0, 1.0, 0.45)[:, None]
    outline = reach * np.stack([np.sin(turn), -np.cos(turn)], 1)
    for size, color in ((radius + 2, _LEGEND_INK), (radius, _TARGET)):
        cv2.fillPoly(image, [np.round(np.array(at) + size * outline).astype(np.int32)], color, cv2.LINE_AA)
