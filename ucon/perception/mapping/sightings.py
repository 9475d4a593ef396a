"""What single frames showed from the node where the agent stands: the content of prompts that list directions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections
from ucon.perception.mapping.semantic_map import SemanticMap, View, camera_of, frame_depth

FLOOR_CODE = STRUCTURE_KINDS["floors"]
#: Frames from within this distance are of one place, metres: a robot that turns is shifted by a few millimetres.
_SAME_M = 0.1


@dataclass(frozen=True, eq=False)
class Sighting(Shared):
    """What one frame showed, kept until the agent moves on."""

    view: View
    things: tuple[tuple[str, int], ...]
    """Categories in view and the number of each, by falling pixels; without structure."""
    floor_xy: tuple[float, float] | None
    """Centre of the largest patch of floor in view, metres in the start frame; None if none is in view or wanted."""
    rgb: NDArray[np.uint8] | None = None
    """(H, W, 3); None unless images are kept."""


class Sightings:
    """The newest level frame of each heading at the node where the agent stands."""

    def __init__(self, *, floor: bool = False, images: bool = False) -> None:
        """Choose what is kept of a frame.

        Args:
            floor: compute the centre of the largest patch of floor.
            images: keep the colour images.
        """
        self._floor, self._images = floor, images
        self._at: tuple[float, float] | None = None
        self._frames: dict[int, _Frame] = {}

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Mapping[str, Any]) -> None:
        """Keep a frame if it is level; frames of other nodes are dropped.

        Args:
            known: the map, updated with this frame.
            observation: of the frame.
            info: of the frame.
        """
        view = known.view
        if self._at is None or math.dist(self._at, view.xy) > _SAME_M:
            self._at, self._frames = view.xy, {}
        if view.pitch_deg == 0:
            rgb = observation.get("rgb") if self._images else None
            self._frames[view.heading] = _Frame(view, Detections.from_info(info), frame_depth(observation, info), rgb)

    def of(self, known: SemanticMap) -> list[Sighting]:
        """What was seen from the current node, one entry for each heading kept.

        Returns:
            In order of heading, beginning with the current one and turning left.
        """
        n = known.body.headings
        order = [(known.view.heading + turn) % n for turn in range(n)]
        return [self._sighting(known, self._frames[heading]) for heading in order if heading in self._frames]

    def _sighting(self, known: SemanticMap, frame: _Frame) -> Sighting:
        floor = _floor_middle(known, frame) if self._floor else None
        return Sighting(frame.view, _things(frame.found), floor, frame.rgb)


@dataclass(frozen=True, eq=False)
class _Frame:
    view: View
    found: Detections
    depth: NDArray[np.float32]
    rgb: NDArray[np.uint8] | None


def _things(found: Detections) -> tuple[tuple[str, int], ...]:
    """Categories and their numbers, by falling pixels; without structure."""
    size: dict[str, int] = {}
    count: dict[str, int] = {}
    for name, pixels in zip(found.category, found.pixels.tolist(), strict=True):
        if name not in STRUCTURE_KINDS:
            size[name] = size.get(name, 0) + pixels
            count[name] = count.get(name, 0) + 1
    order = sorted(size, key=lambda name: (-size[name], name))
    return tuple((name, count[name]) for name in order)


def _floor_middle(known: SemanticMap, frame: _Frame) -> tuple[float, float] | None:
    """Centre of the largest patch of floor, metres in the start frame; None where no floor is in view."""
    is_floor = np.zeros(known.n_tracks + 1, np.uint8)  # the last entry: pixels of no track
    is_floor[:-1] = known.kind[: known.n_tracks] == FLOOR_CODE
    mask = is_floor[frame.found.image]
    count, label, stats, middles = cv2.connectedComponentsWithStats(mask, connectivity=4)
    if count < 2:
        return None
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    rows, columns = np.nonzero(label == largest)
    # The centre of a bent patch may lie outside it: use the nearest pixel of the patch.
    k = int(((columns - middles[largest][0]) ** 2 + (rows - middles[largest][1]) ** 2).argmin())
    return _ground(frame, known.body, int(rows[k]), int(columns[k]))


def _ground(frame: _Frame, body: Body, v: int, u: int) -> tuple[float, float]:
    """The point (x, y) in metres that pixel (row v, column u) shows."""
    x, y, _, c, s, cp, sp, focal_px = camera_of(frame.view, frame.depth, body)
    rows, columns = frame.depth.shape
    d = float(frame.depth[v, u])
    forward = d * (cp - sp * (0.5 * rows - v - 0.5) / focal_px)
    right = d * (u + 0.5 - 0.5 * columns) / focal_px
    return float(x + c * forward + s * right), float(y + s * forward - c * right)
