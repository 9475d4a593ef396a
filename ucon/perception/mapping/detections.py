"""The output of a detector for one frame, which the semantic map takes in.

A track is one thing followed through an episode. Numbers count up from 0 and are never the simulator's own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared

#: A thing counts as seen if it has at least this many pixels in a 128 x 128 view of 90 degrees.
MIN_PIXELS = 4
#: Codes of tracks that are structure, not things. ``obstacles``: what blocks the way and was not named by the detector.
STRUCTURE_KINDS = {"floors": 1, "walls": 2, "ceilings": 3, "obstacles": 4}


@dataclass(frozen=True, slots=True)
class Detections(Shared):
    """What was seen in one frame. All arrays but ``image`` have one row for each track in view."""

    track: NDArray[np.signedinteger[Any]]
    """(n,) track numbers, ascending."""
    category: Sequence[str]
    """n names of the catalogue or of :data:`STRUCTURE_KINDS`."""
    pixels: NDArray[np.int32]
    """(n,) pixels of each track."""
    image: NDArray[np.int16]
    """(H, W) track of every pixel, -1 where there is none."""
    score: NDArray[np.float32] | None = None
    """(n,) the detector's confidence from 0 to 1; None where it is never wrong."""

    @classmethod
    def from_info(cls, info: Mapping[str, Any]) -> Detections:
        """Read the detections of an environment's info.

        Args:
            info: ``detections`` (an object or a mapping with track, category, pixels, perhaps score) and ``tracks``,
                the track of every pixel (H, W).
        """
        raw = info["detections"]
        if isinstance(raw, Mapping):
            track, category, pixels, score = raw["track"], raw["category"], raw["pixels"], raw.get("score")
        else:
            track, category, pixels, score = raw.track, raw.category, raw.pixels, getattr(raw, "score", None)
        return cls(np.asarray(track, np.int32), list(category), np.asarray(pixels, np.int32), info["tracks"], score)
