"""Timing that is robust to a busy machine and a full heap: the fastest of a few tries, in CPU seconds."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable

import pytest
from numpy._core._multiarray_umath import __cpu_features__

#: For limits that other processors than the one they were set on are known to miss; checked only on the latter.
where_it_was_set = pytest.mark.skipif(
    not __cpu_features__.get("AVX512_SKX"), reason="set on a processor with AVX-512, which this one has not"
)


def fastest_s(action: Callable[[], object], tries: int = 3, at_least_s: float = 0.3) -> float:
    """Least CPU time of at least ``tries`` calls and ``at_least_s`` seconds, without garbage collection in between.

    A call of milliseconds is slowed while another program shares its caches: three tries in a row may all fall into the
    same bad moment, a third of a second of tries seldom does.
    """
    gc.collect()
    gc.disable()
    try:
        spent = [_seconds(action) for _ in range(tries)]
        while sum(spent) < at_least_s:
            spent.append(_seconds(action))
        return min(spent)
    finally:
        gc.enable()


def _seconds(action: Callable[[], object]) -> float:
    start = time.process_time()
    action()
    return time.process_time() - start
