"""Reading regular files of limited size: no folders, pipes or devices."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ucon.core.errors import DataError


def read_plain(path: Path, most: int) -> bytes:
    """Read a regular file (or a link to one).

    Args:
        path: the file.
        most: largest size in bytes.

    Raises:
        FileNotFoundError: there is no such file.
        DataError: it is a folder, a pipe (which would block) or a device, too large, or cannot be read.
    """
    try:
        with _opened(path) as file:
            size = os.fstat(file.fileno()).st_size
            if size > most:
                raise DataError(f"{path}: has {size} bytes, expected at most {most}; restore it")
            return file.read(size)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); restore it") from None


def read_bounded(path: Path, most: int) -> bytes:
    """As :func:`read_plain`, for callers with their own error messages.

    Args:
        path: the file.
        most: of a larger file, the first ``most`` + 1 bytes are read.

    Raises:
        OSError: it cannot be read or is not a regular file; ``strerror`` says why.
    """
    with _opened(path) as file:
        return file.read(most + 1)


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        mode = os.fstat(handle).st_mode
        if not stat.S_ISREG(mode):
            raise OSError(errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL, f"{_kind(mode)}, not a file", str(path))
        with os.fdopen(handle, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(handle)


def _kind(mode: int) -> str:
    return "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device"
