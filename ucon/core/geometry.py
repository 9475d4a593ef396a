"""Frames and rotations. Right-handed, z up, metres; heading 0 looks along +x, headings turn counter-clockwise.

Quaternions are ``xyzw``. Turns of 90 degrees use exact cosines, so that images do not depend on the maths library.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Vec = NDArray[np.float64]

#: Exact (cos, sin) of the four headings 0, 90, 180, 270 degrees, counter-clockwise.
HEADING_COS: Final = (1.0, 0.0, -1.0, 0.0)
HEADING_SIN: Final = (0.0, 1.0, 0.0, -1.0)


def yaw_matrix(quarter_turns: int) -> Vec:
    """Exact rotation about z.

    Args:
        quarter_turns: counter-clockwise.

    Returns:
        (3, 3) float64.
    """
    c, s = HEADING_COS[quarter_turns % 4], HEADING_SIN[quarter_turns % 4]
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def matrix_from_quat(quat_xyzw: Vec) -> Vec:
    """Rotation matrix of a quaternion.

    Args:
        quat_xyzw: (4,), normalised first.

    Returns:
        (3, 3) float64.
    """
    x, y, z, w = np.asarray(quat_xyzw, float) / np.linalg.norm(quat_xyzw)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix_from_rpy(rpy_rad: tuple[float, float, float]) -> Vec:
    """Rotation matrix (3, 3) of roll, pitch, yaw in radians about fixed axes, as in URDF and PyBullet."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy_rad), np.sin(rpy_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def axis_angle_matrix(axis: Vec, angle_rad: float) -> Vec:
    """Rotation matrix about an axis.

    Args:
        axis: (3,), of length 1.
        angle_rad: counter-clockwise.

    Returns:
        (3, 3) float64.
    """
    x, y, z = axis
    c, s = float(np.cos(angle_rad)), float(np.sin(angle_rad))
    return np.array(
        [
            [c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)],
        ]
    )
