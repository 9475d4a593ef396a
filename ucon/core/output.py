"""Standard output that holds nothing but a command's own result, whole."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

#: Tables are as wide as they need to be: in a narrow terminal lines break, but no figure is cut off.
_LEAST_WIDTH = 132


def is_wide() -> bool:
    """Whether standard output has room for whole tables; where it is no terminal, 80 columns are taken."""
    from rich.console import Console

    return Console().width >= _LEAST_WIDTH


def wide_console() -> Console:
    """A console for tables on standard output."""
    from rich.console import Console

    return Console(width=max(Console().width, _LEAST_WIDTH))


@contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Send what libraries print meanwhile (PyBullet its build time, in C) to standard error."""
    sys.stdout.flush()
    saved = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(saved, 1)
        os.close(saved)


@cache
def say_once(line: str) -> None:
    """Print a line to standard error, once, and not again from the worker processes."""
    if multiprocessing.parent_process() is None:
        print(line, file=sys.stderr)


def say_written(path: Path, what: str) -> None:
    """Say on standard error, so that standard output stays what it is, what was written where."""
    sys.stderr.write(f"{path}: {what}, {path.stat().st_size / 1024:.0f} KB\n")
