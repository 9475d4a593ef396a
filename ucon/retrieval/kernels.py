"""The product of a query with every habit's vector.

A whole release is some 22,600 vectors: the time goes into fetching them. So they stay in fp16, which Numba does not
know, and are widened by their bits on the way; every step is exact, so the sums are those of float32 vectors.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F64, U16, jit, merged

#: Sums kept side by side, so that a processor adds several at once without the order of additions being free.
LANES = 16

#: fp16 has 10 bits of fraction and an exponent that counts from 15, fp32 has 23 and 127.
FRACTION = np.uint32(23 - 10)
REBASED = np.uint32((127 - 15) << 23)
#: Below this pattern fp16 has no leading one, and counts in steps from zero up to ``LEAST``.
SUBNORMAL = np.uint32(1 << 10)
LEAST = np.float32(2.0**-14)


@merged
def widened(half: np.uint16) -> np.float32:
    """The number, finite, that 16 bits stand for. No subnormal fp32 on the way: those are slow, or flushed to zero."""
    pattern = np.uint32(half)
    size = pattern & np.uint32(0x7FFF)
    wide = np.uint32((size << FRACTION) + REBASED)
    normal = wide.view(np.float32)
    small = np.uint32(wide + np.uint32(1 << 23)).view(np.float32) - LEAST
    value = small if size < SUBNORMAL else normal
    return -value if pattern & np.uint32(0x8000) else value


@jit
def products(halves: U16, query: F64, out: F64) -> None:
    """Each row (n, dim) times ``query`` (dim,), summed in float64 in the same order on every machine, into ``out``.

    ``halves`` are the bits of fp16 numbers.
    """
    whole = query.size // LANES * LANES
    sums = np.empty(LANES)
    for i in range(len(halves)):
        sums[:] = 0.0
        for k in range(0, whole, LANES):
            for lane in range(LANES):
                sums[lane] += np.float64(widened(halves[i, k + lane])) * query[k + lane]
        total = 0.0
        for lane in range(LANES):
            total += sums[lane]
        for k in range(whole, query.size):
            total += np.float64(widened(halves[i, k])) * query[k]
        out[i] = total
