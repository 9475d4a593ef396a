"""How glibc keeps memory."""

from __future__ import annotations

import ctypes
import sys
from typing import Final

#: Numbers of ``mallopt`` (malloc.h), and what is set: no mapping of its own for large blocks; keep what is freed; take
#: 64 MiB at a time; one arena for all threads.
_MMAP_MAX, _TRIM_THRESHOLD, _TOP_PAD, _ARENA_MAX = -4, -1, -2, -8
_SETTINGS: Final = ((_MMAP_MAX, 0), (_TRIM_THRESHOLD, 2**31 - 1), (_TOP_PAD, 64 << 20), (_ARENA_MAX, 1))


def keep_freed_memory() -> bool:
    """Let this process keep freed memory for its next tensors; False where the C library has no such setting.

    By default glibc gives every large block back to the system and asks for it anew, page by page. Training spends a
    sixth of its time on that.
    """
    if not sys.platform.startswith("linux"):
        return False
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    return mallopt is not None and all(mallopt(name, value) for name, value in _SETTINGS)
