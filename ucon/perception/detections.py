"""What a detector says about one frame: the contract between detectors and the semantic map.

A track is one thing followed through an episode: numbers count up in order of first sight and are never the
simulator's own. The ``gt`` detector of the environment fills these; others must give the same fields.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: A thing counts as seen from this many pixels on, in a 128 x 128 view of 90 degrees.
MIN_PIXELS = 4
STRUCTURE_KINDS = {"floors": 1, "walls": 2, "ceilings": 3}


@dataclass(frozen=True, slots=True)
class Detections:
    """Things seen in one frame."""

    track: NDArray[np.int32]
    """(n,) track numbers."""
    category: Sequence[str]
    """n catalogue names."""
    pixels: NDArray[np.int32]
    """(n,) pixels of each."""
    image: NDArray[np.int16]
    """(H, W) track of every pixel, -1 where there is none."""

    @classmethod
    def from_info(cls, info: Mapping[str, Any]) -> Detections:
        """Read an environment's ``info["detections"]`` (an object or a mapping) and ``info["tracks"]``."""
        raw = info["detections"]
        field = raw.__getitem__ if isinstance(raw, Mapping) else partial(getattr, raw)
        track, pixels = np.asarray(field("track"), np.int32), np.asarray(field("pixels"), np.int32)
        return cls(track, list(field("category")), pixels, info["tracks"])
