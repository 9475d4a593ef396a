"""Vectors as small integers, so that their products are exact.

A product of two int8 vectors of length 384 stays below 2**24, so float32 adds it up without rounding in whatever
order: cosines do not depend on the batch they were computed in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Quantised:
    """Unit vectors: ``codes`` (n, dim) int8 times ``scale`` (n,) float32, each row of length 1."""

    codes: NDArray[np.int8]
    scale: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.codes)

    def take(self, rows: NDArray[np.integer]) -> Quantised:
        """Some rows."""
        return Quantised(self.codes[rows], self.scale[rows])


def quantise(vectors: NDArray[np.floating]) -> Quantised:
    """Int8 codes of vectors (n, dim), largest component 127, scaled back to unit length."""
    values = np.asarray(vectors, np.float32)
    top = np.maximum(np.abs(values).max(axis=1, initial=1e-9), 1e-9)
    codes = np.rint(values * (np.float32(127) / top)[:, None]).astype(np.int8)
    squares = (codes.astype(np.int64) ** 2).sum(axis=1)
    return Quantised(codes, (1 / np.sqrt(np.maximum(squares, 1))).astype(np.float32))


def cosines(a: Quantised, b: Quantised) -> NDArray[np.float32]:
    """Cosines (n_a, n_b), the same bits in every batch."""
    products = a.codes.astype(np.float32) @ b.codes.astype(np.float32).T
    return products * a.scale[:, None] * b.scale[None, :]
