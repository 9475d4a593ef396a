"""What a stereo depth camera makes of a true depth image: range, errors and shadows; 0 means no reading.

The camera is an Intel RealSense D435: lenses 50 mm apart, a focal length of 424 pixels at 848 x 480 (90 degrees), and
disparities that are right to 0.08 pixels, so that depth errs by z^2 0.08 / (424 x 0.05 m): 4 mm at 1 m, 6 cm at 4 m
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


#: Standard deviation of the sum of four uniform 16 bit numbers, and its mean.
_SPREAD: Final = math.sqrt((2.0**32 - 1.0) / 3.0)
_MIDDLE: Final = 2.0 * (2.0**16 - 1.0)


@merged
def _normal(key: int, pixel: int) -> float:
    """A draw for a pixel, nearly of the standard normal distribution: the sum of four uniform ones."""
    bits = np.uint64(key) + np.uint64(pixel + 1) * np.uint64(0x9E3779B97F4A7C15)
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    bits ^= bits >> np.uint64(31)
    low, half = np.uint64(0xFFFF), np.uint64(16)
    total = (bits & low) + ((bits >> half) & low) + ((bits >> np.uint64(32)) & low) + (bits >> np.uint64(48))
    return (float(total) - _MIDDLE) / _SPREAD


@jit
def stereo(depth: F32, key: int, focal_px: float) -> None:
    """Turn true depth into readings.

    Args:
        depth: (H, W) float32, metres along the optical axis; overwritten, 0 where there is no reading.
        key: of the random draws, a whole number from 0 up to 2 ** 63.
        focal_px: focal length of the image, pixels.
    """
    rows, columns = depth.shape
    for v in range(rows):
        covered = np.inf  # leftmost column of the other lens that something to the right of here takes
        for u in range(columns - 1, -1, -1):
            z = float(depth[v, u])
            column = u - focal_px * BASELINE_M / z if z > 0.0 else np.inf
            seen = column < covered
            covered = min(covered, column)
            reading = 0.0
            if seen and NEAREST_M <= z <= FARTHEST_M:
                reading = z + ERROR_AT_1_M * z * z * _normal(key, v * columns + u)
                reading = math.floor(reading * 1000.0 + 0.5) / 1000.0
            depth[v, u] = np.float32(reading)
