"""Readings of a stereo depth camera from a true depth image: range, errors and shadows; 0 means no reading.

The camera is an Intel RealSense D435: lenses 50 mm apart, a focal length of 424 pixels at 848 x 480 (90 degrees), and
disparities accurate to 0.08 pixels, so that the error of depth is z^2 0.08 / (424 x 0.05 m): 4 mm at 1 m, 6 cm at 4 m
("Subpixel Linearity Improvement for Intel RealSense Depth Camera D400 Series", dev.intelrealsense.com; data sheet of
the D400 series). It reads nothing nearer than 0.3 m or farther than 6 m, and nothing that one of its lenses does not
see: a shadow to the left of whatever stands in front. Readings are whole millimetres.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ucon.core.jit import F32, jit, merged

NEAREST_M: Final = 0.3
FARTHEST_M: Final = 6.0
BASELINE_M: Final = 0.05
#: Standard error of a reading at 1 m; it grows with the square of the distance.
ERROR_AT_1_M: Final = 0.08 / (424.0 * BASELINE_M)


#: Mean and standard deviation of the sum of four uniform bytes.
_MIDDLE: Final = 510.0
_SPREAD: Final = math.sqrt((2.0**16 - 1.0) / 3.0)


@merged
def _normal(key: int, pixel: int) -> float:
    """A draw for a pixel, nearly standard normal: the sum of the bytes of a 32-bit hash.

    The hash is the finaliser of MurmurHash3, in numbers of 64 bits, of which the processor handles several at a time.
    """
    word = np.uint64(0xFFFFFFFF)
    bits = (np.uint64(key) + np.uint64(pixel) * np.uint64(0x9E3779B9)) & word
    bits = ((bits ^ (bits >> np.uint64(16))) * np.uint64(0x85EBCA6B)) & word
    bits = ((bits ^ (bits >> np.uint64(13))) * np.uint64(0xC2B2AE35)) & word
    bits ^= bits >> np.uint64(16)
    byte = np.uint64(0xFF)
    low = (bits & byte) + ((bits >> np.uint64(8)) & byte)
    high = ((bits >> np.uint64(16)) & byte) + (bits >> np.uint64(24))
    return (np.float64(np.int64(low + high)) - _MIDDLE) / _SPREAD


@jit
def stereo(depth: F32, key: int, focal_px: float) -> None:
    """Turn true depth into readings.

    Args:
        depth: (H, W) float32, metres along the optical axis; overwritten, 0 where there is no reading.
        key: of the random draws, a whole number from 0 up to 2 ** 63.
        focal_px: focal length of the image, pixels.
    """
    rows, columns = depth.shape
    reading, column = np.empty(columns), np.empty(columns)
    shift = focal_px * BASELINE_M
    key = (key ^ (key >> 32)) & 0xFFFFFFFF
    for v in range(rows):
        for u in range(columns):
            z = max(float(depth[v, u]), 1e-3)
            column[u] = u - shift / z
            err = ERROR_AT_1_M * z * z * _normal(key, v * columns + u)
            inside = NEAREST_M <= z <= FARTHEST_M
            reading[u] = math.floor((z + err) * 1000.0 + 0.5) * 1e-3 if inside else 0.0
        covered = np.inf  # leftmost column of the other lens that something to the right of here takes
        for u in range(columns - 1, -1, -1):
            depth[v, u] = np.float32(reading[u]) if column[u] < covered else np.float32(0.0)
            covered = min(covered, column[u])
