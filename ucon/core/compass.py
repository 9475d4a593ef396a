"""The headings of an agent: four of 90 degrees (the paper's simulator), or six of 60 (its real robot).

Heading h of n looks along 360 h / n degrees, counter-clockwise from +x. A view is as wide as a turn, so n views are a
full circle.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.jit import merged

_HALF_ROOT_3 = math.sqrt(0.75)
#: (cos, sin) of heading h of n in row [n, h]; exact for four headings.
DIRECTIONS: Final[NDArray[np.float64]] = np.zeros((7, 6, 2))
DIRECTIONS[4, :4] = np.stack([HEADING_COS, HEADING_SIN], 1)
DIRECTIONS[6, :, 0] = (1.0, 0.5, -0.5, -1.0, -0.5, 0.5)
DIRECTIONS[6, :, 1] = (0.0, _HALF_ROOT_3, _HALF_ROOT_3, 0.0, -_HALF_ROOT_3, -_HALF_ROOT_3)
#: The node (da, db) of the triangular lattice that a move along heading h of six leads to. Node (a, b) is at
#: ``start + move (a e0 + b e1)``, with e0 along heading 0 and e1 along heading 1.
LATTICE_STEPS: Final[NDArray[np.int32]] = np.array([(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)], np.int32)
#: Tangent of half the width of a view, by the number of headings; 1 for four.
TAN_HALF: Final[NDArray[np.float64]] = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, math.sqrt(1.0 / 3.0)])


@merged
def sector(angle_turns: float, n: int) -> int:
    """The heading of n that is nearest to an angle, given as a fraction of a turn from 0 up."""
    return int(angle_turns * n + 0.5) % n


def heading_to(dx: float, dy: float, n: int) -> int:
    """The heading of n in which a point lies.

    Args:
        dx: x component of the vector to the point, in any unit.
        dy: y component.
        n: number of headings.
    """
    if n == 4:  # exact on the diagonals
        if abs(dx) >= abs(dy):
            return 0 if dx > 0 else 2
        return 1 if dy > 0 else 3
    return round(math.atan2(dy, dx) * n / (2.0 * math.pi)) % n
