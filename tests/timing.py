"""Timing that a busy machine and a full heap do not upset: the fastest of a few tries, in CPU seconds."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable


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
