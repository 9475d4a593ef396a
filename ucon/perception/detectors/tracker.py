"""Tracks labelled boxes through an episode: boxes and depth become 3-D boxes, and these become tracks.

A box joins the nearest track of its category if the two can be one thing. A track takes at most one box a frame. Pixels
in no box are floor, wall, ceiling or obstacle by geometry; these have the first four tracks of every episode.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors import tracker_kernels as kernels
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.mapping.detections import MIN_PIXELS, Detections
from ucon.perception.mapping.semantic_map import HALF, SIZE

#: Categories of tracks 0 to 3, in the order of the kernels' codes.
STRUCTURE = ("floors", "walls", "ceilings", "obstacles")
#: Boxes of one category farther apart than this, in metres, are two things.
GATE_M = 0.3
#: Most tracks of an episode: track numbers are int16.
MOST_TRACKS = 32000
_NOTHING = np.array([1e3, 1e3, 1e3, -1e3, -1e3, -1e3])


class Tracker(PartlyShared):
    """The tracks of one episode.

    Attributes:
        category: name of every track; the first four are :data:`STRUCTURE`.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"category", "_box"})

    def __init__(self, gate_m: float = GATE_M) -> None:
        """Start without tracks.

        Args:
            gate_m: largest gap in metres between what two frames show of one thing.
        """
        self._gate_m = gate_m
        self.reset()

    def reset(self) -> None:
        """Start an episode: only the four tracks of structure exist."""
        self.category = list(STRUCTURE)
        self._box: list[NDArray[np.float64]] = [_NOTHING] * len(STRUCTURE)
        self._same: dict[str, list[int]] = {}
        self._upright = np.zeros((2, SIZE, SIZE), np.uint8)

    def follow(self, boxes: Boxes, frame: Frame) -> Detections:
        """Assign the boxes of one frame to tracks.

        Args:
            boxes: n boxes in the frame's pixels.
            frame: its depth and camera.

        Returns:
            Tracks in view, structure first, then those of boxes with at least one pixel; and the track of every pixel.
        """
        depth, camera = frame.depth, frame.camera
        boxes, pixels_of = _painted(boxes, depth.shape)
        n = len(pixels_of)
        owner = np.full(depth.shape, -1, np.int16)
        extent, count = np.tile(_NOTHING, (n, 1)), np.zeros(n, np.int32)
        masks = np.zeros((0, 0, 0), bool) if boxes.mask is None else boxes.mask
        size_m = np.array([_most_m(label) for label in boxes.label])
        kernels.segment(depth, pixels_of, masks, size_m, camera, owner, extent, count)
        track = self._associate(boxes, extent, count)
        image = np.append(track, np.int16(-1))[owner]
        kernels.structure(depth, camera, HALF, self._upright, image)
        return self._detections(boxes, track, count, image)

    def _detections(
        self, boxes: Boxes, track: NDArray[np.int16], count: NDArray[np.int32], image: NDArray[np.int16]
    ) -> Detections:
        """The output of one frame: tracks ascending, with names, pixel counts and scores."""
        building = np.array([np.count_nonzero(image == k) for k in range(len(STRUCTURE))], np.int32)
        shown = np.flatnonzero(building >= MIN_PIXELS)
        rows = np.flatnonzero(track >= 0)
        rows = rows[np.argsort(track[rows])]
        tracks = np.concatenate([shown, track[rows]]).astype(np.int16)
        names = tuple(self.category[k] for k in tracks)
        pixels = np.concatenate([building[shown], count[rows]]).astype(np.int32)
        score = np.concatenate([np.ones(len(shown)), boxes.score[rows]]).astype(np.float32)
        return Detections(tracks, names, pixels, image, score)

    def _associate(self, boxes: Boxes, extent: NDArray[np.float64], count: NDArray[np.int32]) -> NDArray[np.int16]:
        """Track of every box, (n,) int16; -1 for boxes without pixels. New tracks are numbered by falling size."""
        track = np.full(len(count), -1, np.int16)
        pairs = []
        for k in np.flatnonzero(count).tolist():
            for old in self._same.get(boxes.label[k], ()):
                cost = self._cost(boxes.label[k], self._box[old], extent[k])
                if cost is not None:
                    pairs.append((cost, old, k))
        taken: set[int] = set()
        for _, old, k in sorted(pairs):
            if track[k] < 0 and old not in taken:
                track[k] = old
                taken.add(old)
                self._box[old] = _union(self._box[old], extent[k])
        fresh = [k for k in np.flatnonzero(count).tolist() if track[k] < 0]
        for k in sorted(fresh, key=lambda k: (-count[k], k)):
            if len(self.category) < MOST_TRACKS:
                track[k] = len(self.category)
                self._same.setdefault(boxes.label[k], []).append(len(self.category))
                self.category.append(boxes.label[k])
                self._box.append(extent[k].copy())
        return track

    def _cost(self, label: str, old: NDArray[np.float64], new: NDArray[np.float64]) -> float | None:
        """How badly a 3-D box (6,) fits a track's; None where together they are too large or too far apart."""
        gap = float(np.linalg.norm(np.maximum(np.maximum(old[:3] - new[3:], new[:3] - old[3:]), 0.0)))
        whole = _union(old, new)
        # A box that is too large already, by a poor detection or a wrong name, may still join its own track.
        most = max(_most_m(label), _diagonal(old), 1.15 * _diagonal(new))
        if gap > self._gate_m or _diagonal(whole) > most:
            return None
        between = 0.5 * (old[:3] + old[3:] - new[:3] - new[3:])
        return gap + 0.1 * float(np.linalg.norm(between))


def _painted(boxes: Boxes, shape: tuple[int, ...]) -> tuple[Boxes, NDArray[np.int32]]:
    """Boxes from the largest to the smallest, and their integer pixels (n, 4) clipped to the frame, at least 1 x 1."""
    area = np.prod(boxes.xyxy[:, 2:] - boxes.xyxy[:, :2], axis=1)
    boxes = boxes.keep(np.argsort(-area, kind="stable"))
    edge = np.array([shape[1], shape[0]])
    low = np.clip(np.round(boxes.xyxy[:, :2]), 0, edge - 1)
    high = np.clip(np.round(boxes.xyxy[:, 2:]), low + 1, edge)
    return boxes, np.concatenate([low, high], axis=1).astype(np.int32)


def _union(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 3-D box (6,) that holds two boxes."""
    return np.concatenate([np.minimum(a[:3], b[:3]), np.maximum(a[3:], b[3:])])


def _diagonal(box: NDArray[np.float64]) -> float:
    """Length of a 3-D box's diagonal in metres."""
    return float(np.linalg.norm(box[3:] - box[:3]))


def _most_m(label: str) -> float:
    """Longest plausible diagonal of a thing of a category, in metres.

    Half as long again as the catalogue's, and 0.5 m: sizes vary, doors swing out, boxes hold some background.
    """
    book = catalogue()
    return 1.2 * float(np.linalg.norm(book[label].size)) + 0.1 if label in book else 3.0
