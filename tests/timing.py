"""Timing that a busy machine, a full heap and a slow processor do not upset: the fastest of a few tries, in CPU seconds
of the machine that the bars were set on.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from functools import cache
from typing import Final

#: CPU seconds of :func:`_sum` there, from its share of what an evaluation takes there and on a slower machine.
_THERE_S: Final = 0.055


def fastest_s(action: Callable[[], object], tries: int = 3) -> float:
    """Least CPU time of ``tries`` calls, without garbage collection in between, over :func:`slowness`."""
    return _fastest(action, tries) / slowness()


@cache
def slowness() -> float:
    """How many times longer this processor takes than the one that the bars were set on; 1 where it is faster."""
    return max(1.0, _fastest(_sum, 7) / _THERE_S)


def _sum() -> int:
    return sum(i * i % 7 for i in range(10**6))


def _fastest(action: Callable[[], object], tries: int) -> float:
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
