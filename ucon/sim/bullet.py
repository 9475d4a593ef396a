"""The only place where PyBullet is imported: at first use, with its greeting suppressed."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from functools import lru_cache
from types import ModuleType

from ucon.core.errors import UconError


@lru_cache(maxsize=1)
def bullet() -> ModuleType:
    """The ``pybullet`` module.

    Raises:
        UconError: PyBullet is not installed (it has wheels for Python 3.10 and 3.11).
    """
    try:
        with _Quiet():
            import pybullet
    except ImportError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise UconError(
            f"PyBullet is needed to build homes and place objects, and is missing from this Python {version} "
            f"({error}); use Python 3.10 or 3.11, or load homes and episodes that are already compiled"
        ) from None
    return pybullet


class _Quiet:
    """Suppresses output on the C level: PyBullet's greeting would spoil a command's ``--json`` output."""

    def __enter__(self) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        self._saved = [os.dup(1), os.dup(2)]
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        os.close(null)

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError, TypeError, AttributeError):
            (ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)).fflush(None)
        for target, saved in zip((1, 2), self._saved, strict=True):
            os.dup2(saved, target)
            os.close(saved)
