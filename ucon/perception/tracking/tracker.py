"""Tracks labelled boxes through an episode: boxes and depth become 3-D boxes, and these become tracks.

A box joins the nearest track that was called by its name before, if the two can be one thing; else a track that it
covers, whatever its names, so that a thing that the detector calls by two names is one track. A track takes at most one
box a frame. Pixels in no box are floor, wall, ceiling or obstacle by geometry; these have the first four tracks of
every episode.
"""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.mapping.detections import MIN_PIXELS, Detections
from ucon.perception.mapping.semantic_map import HALF, SIZE
from ucon.perception.tracking.association_kernels import associate
from ucon.perception.tracking.segment_kernels import segment
from ucon.perception.tracking.structure_kernels import structure

#: Categories of tracks 0 to 3, in the order of the kernels' codes.
STRUCTURE = ("floors", "walls", "ceilings", "obstacles")
#: Boxes of one category farther apart than this, in metres, are two things.
GATE_M = 0.3
#: Most names of a track that are remembered.
MOST_NAMES = 6
#: Most tracks of an episode: track numbers are int16.
MOST_TRACKS = 32000
_NOTHING = np.array([1e3, 1e3, 1e3, -1e3, -1e3, -1e3])


class Tracker(PartlyShared):
    """The tracks of one episode; the first four are :data:`STRUCTURE`."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_number", "_box", "_label", "_upright"})

    def __init__(self, gate_m: float = GATE_M) -> None:
        """Start without tracks.

        Args:
            gate_m: largest gap in metres between what two frames show of one thing.
        """
        self._gate_m = gate_m
        self.reset()

    def reset(self) -> None:
        """Start an episode: only the four tracks of structure exist."""
        self._n = len(STRUCTURE)
        self._box: NDArray[np.float64] = np.tile(_NOTHING, (64, 1))
        self._label = np.full((64, MOST_NAMES), -1, np.int32)
        self._number: dict[str, int] = {}
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
        segment(depth, pixels_of, masks, size_m, camera, owner, extent, count)
        track = self._associate(boxes, size_m, extent, count)
        image = np.append(track, np.int16(-1))[owner]
        structure(depth, camera, HALF, self._upright, image)
        return self._detections(boxes, track, count, image)

    def _detections(
        self, boxes: Boxes, track: NDArray[np.int16], count: NDArray[np.int32], image: NDArray[np.int16]
    ) -> Detections:
        """The output of one frame: tracks ascending, with the names of this frame, pixel counts and scores."""
        # Every second row and column is classified.
        building = 4 * np.bincount(image[::2, ::2].ravel() + 1, minlength=len(STRUCTURE) + 1)[1 : len(STRUCTURE) + 1]
        shown = np.flatnonzero(building >= MIN_PIXELS)
        rows = np.flatnonzero(track >= 0)
        rows = rows[np.argsort(track[rows])]
        tracks = np.concatenate([shown, track[rows]]).astype(np.int16)
        names = (*(STRUCTURE[k] for k in shown.tolist()), *(boxes.label[k] for k in rows.tolist()))
        pixels = np.concatenate([building[shown], count[rows]]).astype(np.int32)
        score = np.concatenate([np.ones(len(shown)), boxes.score[rows]]).astype(np.float32)
        return Detections(tracks, names, pixels, image, score)

    def _associate(
        self, boxes: Boxes, size_m: NDArray[np.float64], extent: NDArray[np.float64], count: NDArray[np.int32]
    ) -> NDArray[np.int16]:
        """Track of every box, (n,) int16; -1 for boxes without pixels. New tracks are numbered by falling size."""
        track, old = np.empty(len(count), np.int16), self._n
        label = np.array([self._number.setdefault(name, len(self._number)) for name in boxes.label], np.int32)
        associate(extent, count, label, size_m, self._box[:old], self._label[:old], self._gate_m, track)
        fresh = np.flatnonzero((count > 0) & (track < 0))
        for k in fresh[np.lexsort((fresh, -count[fresh]))].tolist():
            new = self._n
            if new >= MOST_TRACKS:
                break
            if new == len(self._box):
                self._box = np.concatenate([self._box, np.tile(_NOTHING, (new, 1))])
                self._label = np.concatenate([self._label, np.full((new, MOST_NAMES), -1, np.int32)])
            track[k], self._box[new], self._label[new, 0] = new, extent[k], label[k]
            self._n += 1
        return track


def _painted(boxes: Boxes, shape: tuple[int, ...]) -> tuple[Boxes, NDArray[np.int32]]:
    """Boxes from the largest to the smallest, and their integer pixels (n, 4) clipped to the frame, at least 1 x 1."""
    area = np.prod(boxes.xyxy[:, 2:] - boxes.xyxy[:, :2], axis=1)
    boxes = boxes.keep(np.argsort(-area, kind="stable"))
    edge = np.array([shape[1], shape[0]])
    low = np.clip(np.round(boxes.xyxy[:, :2]), 0, edge - 1)
    high = np.clip(np.round(boxes.xyxy[:, 2:]), low + 1, edge)
    return boxes, np.concatenate([low, high], axis=1).astype(np.int32)


@lru_cache(maxsize=2048)
def _most_m(label: str) -> float:
    """Longest plausible diagonal of a thing of a category, in metres.

    A fifth longer than the catalogue's, plus 0.1 m: sizes vary, and boxes hold some of what is next to a thing.
    """
    book = catalogue()
    return 1.2 * float(np.linalg.norm(book[label].size)) + 0.1 if label in book else 3.0
