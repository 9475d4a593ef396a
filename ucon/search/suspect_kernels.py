"""Kernel that sums what is expected near suspects."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F64, I32, jit


@jit
def mass_near(
    boxes: F64, tracks: I32, xyz: F64, of: I32, relation: I32, share: F64, expected: F64, near_m: float, mass: F64,
    crowd: F64,
) -> None:  # fmt: skip
    """Sum the expected mass of the sample points in and around the boxes of m things, without the things' own points.

    Args:
        boxes: (m, 6) float64, metres.
        tracks: (m,) int32, the things' tracks.
        xyz: (n, 3) float64, the sample points, metres.
        of: (n,) int32, the sample points' tracks.
        relation: (n,) int32.
        share: (n,) float64, of the mass of a track and relation.
        expected: (T, 4) float64, mass of tracks and relations.
        near_m: how far around a box points count, metres.
        mass: (m, 4) float64, updated: mass by relation.
        crowd: (m,) float64, written: logarithm of one more than the number of other things with points there.
    """
    around = np.empty(expected.shape[0], np.bool_)
    for k in range(boxes.shape[0]):
        around[:] = False
        count = 0
        for n in range(xyz.shape[0]):
            if share[n] <= 0.0 or of[n] == tracks[k]:
                continue
            inside = True
            for axis in range(3):
                at = xyz[n, axis]
                inside = inside and boxes[k, axis] - near_m <= at and at <= boxes[k, 3 + axis] + near_m
            if not inside:
                continue
            mass[k, relation[n]] += expected[of[n], relation[n]] * share[n]
            if not around[of[n]]:
                around[of[n]] = True
                count += 1
        crowd[k] = np.log(1.0 + count)
