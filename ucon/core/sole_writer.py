"""A lock on a run's folder, so that only one command at a time writes to it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from ucon.core.errors import ConfigError

try:
    import fcntl
except ImportError:  # Windows has no locks on folders
    fcntl = None  # type: ignore[assignment]


@contextlib.contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Context that makes a folder and locks it against other commands; the lock ends with the process.

    The folder itself is locked, so no lock file is left. Where that is not possible (Windows, some network drives, a
    folder that cannot be made) there is no lock, and errors appear when something is written.

    Raises:
        ConfigError: another command writes there.
    """
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if fcntl is not None:
                opened = os.open(folder, os.O_RDONLY)
                stack.callback(os.close, opened)
                try:
                    fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise ConfigError(
                        f"{folder}: another command is writing there; wait for it, or choose another folder"
                    ) from None
        yield
