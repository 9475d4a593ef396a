"""Reading files of others: no more than they may hold, and nothing that is no file."""

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
    """Bytes of a file, which a link may name: of no folder, no pipe (which would be waited for) and no device.

    Args:
        path: the file.
        most: bytes that it may have.

    Raises:
        FileNotFoundError: there is none.
        DataError: it is something else, too large, or cannot be read.
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
    """As :func:`read_plain`, but of a larger file the first ``most`` + 1 bytes, for readers with messages of their own.

    Raises:
        OSError: it cannot be read, or is no file; ``strerror`` says what else it is.
    """
    with _opened(path) as file:
        return file.read(most + 1)


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        mode = os.fstat(handle).st_mode
        if not stat.S_ISREG(mode):
            raise OSError(errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL, f"{_kind(mode)}, no file", str(path))
        with os.fdopen(handle, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(handle)


def _kind(mode: int) -> str:
    return "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device"
