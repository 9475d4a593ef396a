"""Reading files of others: no more than they may hold, and nothing that is no file."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ucon.core.errors import DataError


def read_plain(path: Path, most: int) -> bytes:
    """Bytes of a file, which a link may name: of no folder, no pipe (which would be waited for) and no device.

    Args:
        path: the file.
        most: bytes that it may have.

    Raises:
        FileNotFoundError: there is none.
        DataError: it is something else, too large, or cannot be read.
    """
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        raise
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); restore it") from None
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise DataError(f"{path}: is no file but {_kind(found.st_mode)}; restore it")
        if found.st_size > most:
            raise DataError(f"{path}: has {found.st_size} bytes, expected at most {most}; restore it")
        with os.fdopen(handle, "rb", closefd=False) as file:
            return file.read(found.st_size)
    finally:
        os.close(handle)


def _kind(mode: int) -> str:
    return "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device"
