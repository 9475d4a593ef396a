"""The product of a query with every habit's vector.

A whole release has about 22,600 vectors, so the time goes into reading them. They stay in fp16, which Numba does not
support, and are converted by their bits on the way. Every step is exact, so sums equal those of float32 vectors.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F64, U16, jit, merged

#: Number of partial sums: the processor can add several at once, and the order of additions is still fixed.
LANES = 16

#: fp16 has 10 bits of fraction and an exponent that counts from 15, fp32 has 23 and 127.
FRACTION = np.uint32(23 - 10)
REBASED = np.uint32((127 - 15) << 23)
#: Below this pattern fp16 has no leading one, and counts in steps from zero up to ``LEAST``.
SUBNORMAL = np.uint32(1 << 10)
LEAST = np.float32(2.0**-14)


@merged
def widened(half: np.uint16) -> np.float32:
    """The finite fp16 number with these 16 bits, as fp32.

    No subnormal fp32 occurs on the way: those are slow, or flushed to zero.
    """
    pattern = np.uint32(half)
    size = pattern & np.uint32(0x7FFF)
    wide = np.uint32((size << FRACTION) + REBASED)
    normal = wide.view(np.float32)
    small = np.uint32(wide + np.uint32(1 << 23)).view(np.float32) - LEAST
    value = small if size < SUBNORMAL else normal
    return -value if pattern & np.uint32(0x8000) else value


@jit
def products(halves: U16, query: F64, out: F64) -> None:
    """Multiply every row with ``query``, summed in float64 in the same order on every machine.

    Args:
        halves: (n, D) bits of fp16 numbers.
        query: (D,).
        out: (n,) is filled.
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
