"""The product of a query with every habit's vector."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, jit

#: Sums kept side by side, so that a processor adds several at once without the order of additions being free.
LANES = 16


@jit
def products(vectors: F32, query: F64, out: F64) -> None:
    """Each row (n, dim) times ``query`` (dim,), summed in float64 in the same order on every machine, into ``out``."""
    whole = query.size // LANES * LANES
    sums = np.empty(LANES)
    for i in range(len(vectors)):
        sums[:] = 0.0
        for k in range(0, whole, LANES):
            for lane in range(LANES):
                sums[lane] += np.float64(vectors[i, k + lane]) * query[k + lane]
        total = 0.0
        for lane in range(LANES):
            total += sums[lane]
        for k in range(whole, query.size):
            total += np.float64(vectors[i, k]) * query[k]
        out[i] = total
