"""Memory that a process may still use, so that data that cannot fit are refused before they are read."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

_MEMINFO: Final = Path("/proc/meminfo")
_GROUP: Final = Path("/sys/fs/cgroup")


def free_bytes() -> int | None:
    """Bytes that are free here, within the limit of this process's control group; None where it is unknown.

    On systems without ``/proc`` all of the machine's memory counts as free.
    """
    found = [n for n in (_available(), _left_to_group()) if n is not None]
    if found:
        return min(found)
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):  # no such name on this system
        return None


def _available() -> int | None:
    try:
        lines = _MEMINFO.read_text().splitlines()
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, ValueError, IndexError, StopIteration):
        return None


def _left_to_group() -> int | None:
    try:
        most, used = ((_GROUP / name).read_text().strip() for name in ("memory.max", "memory.current"))
        return max(int(most) - int(used), 0)  # "max" where there is no limit
    except (OSError, ValueError):
        return None
