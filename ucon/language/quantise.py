"""Vectors as int8 codes, so that their products are exact.

A product of two int8 vectors of length 384 stays below 2**24, so float32 sums it without rounding in any order. Cosines
do not depend on the batch they are computed in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Quantised:
    """n unit vectors as ``codes`` (n, dim) int8 times ``scale`` (n,) float32."""

    codes: NDArray[np.int8]
    scale: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.codes)

    def take(self, rows: NDArray[np.integer]) -> Quantised:
        """The vectors of some rows."""
        return Quantised(self.codes[rows], self.scale[rows])


def quantise(vectors: NDArray[np.floating]) -> Quantised:
    """Quantise vectors; each has the largest component 127 and is scaled to length 1.

    Args:
        vectors: (n, dim).
    """
    values = np.asarray(vectors, np.float32)
    top = np.maximum(np.abs(values).max(axis=1, initial=1e-9), 1e-9)
    codes = np.rint(values * (np.float32(127) / top)[:, None]).astype(np.int8)
    squares = (codes.astype(np.int64) ** 2).sum(axis=1)
    return Quantised(codes, (1 / np.sqrt(np.maximum(squares, 1))).astype(np.float32))


def cosines(a: Quantised, b: Quantised) -> NDArray[np.float32]:
    """Cosines of all pairs, the same bits in every batch.

    Args:
        a: n_a vectors.
        b: n_b vectors.

    Returns:
        (n_a, n_b) float32.
    """
    products = a.codes.astype(np.float32) @ b.codes.astype(np.float32).T
    return products * a.scale[:, None] * b.scale[None, :]
