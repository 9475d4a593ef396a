"""Settings of glibc's memory allocator."""

from __future__ import annotations

import ctypes
import sys
from typing import Final

#: Parameters of ``mallopt`` (malloc.h) and their values: no separate mappings for large blocks; keep freed memory; take
#: 64 MiB at a time; one arena for all threads.
_MMAP_MAX, _TRIM_THRESHOLD, _TOP_PAD, _ARENA_MAX = -4, -1, -2, -8
_SETTINGS: Final = ((_MMAP_MAX, 0), (_TRIM_THRESHOLD, 2**31 - 1), (_TOP_PAD, 64 << 20), (_ARENA_MAX, 1))


def keep_freed_memory() -> bool:
    """Make this process keep freed memory for its next tensors.

    By default glibc returns every large block to the system and requests it again, page by page. Training spends a
    sixth of its time on that.

    Returns:
        False where the C library has no such setting.
    """
    if not sys.platform.startswith("linux"):
        return False
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    return mallopt is not None and all(mallopt(name, value) for name, value in _SETTINGS)
