"""What a detector says about one frame: the contract between detectors and the semantic map.

A track is one thing followed through an episode: numbers count up in order of first sight and are never the
simulator's own. Every detector of ``ucon/perception/detectors`` fills these.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared

#: A thing counts as seen from this many pixels on, in a 128 x 128 view of 90 degrees.
MIN_PIXELS = 4
#: Tracks of these names are no things. Obstacles block, but what they are is not known: no thing, floor or wall.
STRUCTURE_KINDS = {"floors": 1, "walls": 2, "ceilings": 3, "obstacles": 4}


@dataclass(frozen=True, slots=True)
class Detections(Shared):
    """Things seen in one frame; the first arrays have one row a track."""

    track: NDArray[np.signedinteger[Any]]
    """(n,) track numbers, ascending."""
    category: Sequence[str]
    """n catalogue names, or names of :data:`STRUCTURE_KINDS`."""
    pixels: NDArray[np.int32]
    """(n,) pixels of each."""
    image: NDArray[np.int16]
    """(H, W) track of every pixel, -1 where there is none."""
    score: NDArray[np.float32] | None = None
    """(n,) how sure the detector is of each, from 0 to 1; None where it is never wrong."""

    @classmethod
    def from_info(cls, info: Mapping[str, Any]) -> Detections:
        """Read an environment's ``info["detections"]`` (an object or a mapping) and ``info["tracks"]``."""
        raw = info["detections"]
        if isinstance(raw, Mapping):
            track, category, pixels, score = raw["track"], raw["category"], raw["pixels"], raw.get("score")
        else:
            track, category, pixels, score = raw.track, raw.category, raw.pixels, getattr(raw, "score", None)
        return cls(np.asarray(track, np.int32), list(category), np.asarray(pixels, np.int32), info["tracks"], score)
