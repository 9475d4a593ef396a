"""A picture of the 5 cm map from above, with its frontiers numbered by rank."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.perception.fine_frontiers import FineFrontier, outline
from ucon.perception.fine_kernels import EXPLORED, OBSTACLE, VISITED
from ucon.perception.fine_map import FineMap, cell_of

Image = NDArray[np.uint8]

_UNKNOWN, _FREE, _OBSTACLE = (58, 62, 70), (238, 236, 230), (134, 116, 98)
_VISITED, _EDGE, _AGENT = (150, 180, 220), (90, 200, 220), (24, 60, 140)
#: From the first rank on.
RANKS = ((214, 60, 48), (226, 140, 40), (70, 150, 60), (130, 80, 180))


def draw_fine(fine: FineMap, frontiers: Sequence[FineFrontier] = (), *, cell_px: int = 3) -> Image:
    """Draw explored space, obstacles, the way and the frontiers; x to the right, y up, cropped to what was explored.

    The edge of explored space is light blue. A frontier is a numbered dot, and the pose to go to an arrow.

    Args:
        fine: the map.
        frontiers: as :func:`~ucon.perception.fine_frontiers.fine_frontiers` returns them.
        cell_px: pixels of one 5 cm cell.

    Returns:
        (H, W, 3) uint8.
    """
    box = fine.extent(margin=8)
    image = np.full((box[1] - box[0], box[3] - box[2], 3), _UNKNOWN, np.uint8)
    for bit, color in ((EXPLORED, _FREE), (VISITED, _VISITED), (OBSTACLE, _OBSTACLE)):
        image[fine.layer(bit, box) > 0] = color
    image[outline(fine, box)[1] > 0] = _EDGE
    image = np.repeat(np.repeat(image.transpose(1, 0, 2)[::-1], cell_px, 0), cell_px, 1).copy()

    def px(xy: tuple[float, float]) -> tuple[int, int]:
        a, b = cell_of(xy)
        return round((a - box[0] + 0.5) * cell_px), round((box[3] - b - 0.5) * cell_px)

    for rank, frontier in enumerate(frontiers):
        color = RANKS[min(rank, len(RANKS) - 1)]
        _arrow(image, px, frontier.view.xy, frontier.view.heading, color)
        center = px(frontier.xy)
        cv2.circle(image, center, 8, color, -1, cv2.LINE_AA)
        at = (center[0] - 4, center[1] + 5)
        cv2.putText(image, str(rank + 1), at, cv2.FONT_HERSHEY_PLAIN, 0.9, (255, 255, 255), 1, cv2.LINE_AA)
    cv2.circle(image, px(fine.view.xy), 5, _AGENT, -1, cv2.LINE_AA)
    _arrow(image, px, fine.view.xy, fine.view.heading, _AGENT)
    return image


def _arrow(
    image: Image,
    px: Callable[[tuple[float, float]], tuple[int, int]],
    xy: tuple[float, float],
    heading: int,
    color: tuple[int, int, int],
) -> None:
    """Half a metre from a point along a heading."""
    tip = (xy[0] + 0.5 * (1, 0, -1, 0)[heading], xy[1] + 0.5 * (0, 1, 0, -1)[heading])
    cv2.arrowedLine(image, px(xy), px(tip), color, 2, cv2.LINE_AA, tipLength=0.4)
