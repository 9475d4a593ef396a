"""Timing that a busy machine and a full heap do not upset: the fastest of a few tries, in CPU seconds."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable

import pytest
from numpy._core._multiarray_umath import __cpu_features__

#: Bars that a processor of another kind than the one they were set on is known to miss, or recordings that its NumPy
#: plays otherwise: they are checked where they were made.
where_it_was_set = pytest.mark.skipif(
    not __cpu_features__.get("AVX512_SKX"), reason="set on a processor with AVX-512, which this one has not"
)


def fastest_s(action: Callable[[], object], tries: int = 3) -> float:
    """Least CPU time of ``tries`` calls, without garbage collection in between."""
    gc.collect()
    gc.disable()
    try:
        return min(_seconds(action) for _ in range(tries))
    finally:
        gc.enable()


def _seconds(action: Callable[[], object]) -> float:
    start = time.process_time()
    action()
    return time.process_time() - start
