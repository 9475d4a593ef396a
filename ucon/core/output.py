"""Output of commands: results on standard output, everything else on standard error."""

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

#: Least width of tables in columns: in a narrower terminal lines break, but no number is cut off.
_LEAST_WIDTH = 132


def is_wide() -> bool:
    """Whether standard output is wide enough for whole tables; 80 columns are assumed if it is not a terminal."""
    from rich.console import Console

    return Console().width >= _LEAST_WIDTH


def wide_console() -> Console:
    """A console for tables on standard output, at least 132 columns wide."""
    from rich.console import Console

    return Console(width=max(Console().width, _LEAST_WIDTH))


@contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Context in which everything printed, also by C libraries (PyBullet), goes to standard error."""
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
    """Print a line to standard error, once per process and never from worker processes."""
    if multiprocessing.parent_process() is None:
        print(line, file=sys.stderr)


def say_written(path: Path, what: str) -> None:
    """Print to standard error which file was written and its size.

    Args:
        path: the file.
        what: its content, in words.
    """
    sys.stderr.write(f"{path}: {what}, {path.stat().st_size / 1024:.0f} KB\n")
