"""What a stereo depth camera makes of a true depth image: range, errors and shadows; 0 means no reading.

The camera is an Intel RealSense D435: lenses 50 mm apart, a focal length of 424 pixels at 848 x 480 (90 degrees), and
disparities that are right to 0.08 pixels, so that depth errs by z^2 0.08 / (424 x 0.05 m): 4 mm at 1 m, 6 cm at 4 m
("Subpixel Linearity Improvement for Intel RealSense Depth Camera D400 Series", dev.intelrealsense.com; data sheet of
the D400 series). It reads nothing nearer than 0.3 m or farther than 6 m, and nothing that one of its lenses does not
see: a shadow to the left of whatever stands in front. Readings are whole millimetres.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ucon.core.jit import F32, jit

NEAREST_M: Final = 0.3
FARTHEST_M: Final = 6.0
BASELINE_M: Final = 0.05
#: Standard error of a reading at 1 m; it grows with the square of the distance.
ERROR_AT_1_M: Final = 0.08 / (424.0 * BASELINE_M)


@jit
def stereo(depth: F32, normal: F32, focal_px: float) -> None:
    """Turn true depth into readings.

    Args:
        depth: (H, W) float32, metres along the optical axis; overwritten, 0 where there is no reading.
        normal: (H, W) float32, standard normal draws.
        focal_px: focal length of the image, pixels.
    """
    rows, columns = depth.shape
    for v in range(rows):
        covered = np.inf  # leftmost column of the other lens that something to the right of here takes
        for u in range(columns - 1, -1, -1):
            z = float(depth[v, u])
            column = u - focal_px * BASELINE_M / z if z > 0.0 else np.inf
            shadow = column >= covered
            covered = min(covered, column)
            read = z + ERROR_AT_1_M * z * z * normal[v, u]
            right = NEAREST_M <= z <= FARTHEST_M and NEAREST_M <= read and not shadow
            depth[v, u] = np.float32(round(read * 1000.0) / 1000.0) if right else np.float32(0.0)
