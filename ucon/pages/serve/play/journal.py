"""Every action of a person, written immediately, so that a killed server can continue within the episode."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Final

from ucon.core.errors import DataError
from ucon.core.files import canonical_json
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json

_MOST_BYTES: Final = 1 << 28


class Journal:
    """The actions of one run by episode, in a file with a line for each.

    A last line that was cut off is dropped. An invalid line ends the reading: what follows cannot be replayed.
    """

    def __init__(self, path: Path) -> None:
        """Read the file, if it exists; it is created with the first action.

        Args:
            path: of the file.

        Raises:
            DataError: it cannot be read.
        """
        self._path = path
        self._actions: dict[str, list[int]] = {}
        try:
            raw = read_plain(path, _MOST_BYTES)
        except FileNotFoundError:
            raw = b""
        good = 0
        for line in raw.split(b"\n")[:-1]:
            if not self._take(line):
                break
            good += len(line) + 1
        if good < len(raw):
            os.truncate(path, good)

    def _take(self, line: bytes) -> bool:
        """Read a line; returns whether it is valid."""
        try:
            found = parse_json(line)
        except JsonError:
            return False
        if not isinstance(found, dict) or found.keys() != {"episode", "step", "action"}:
            return False
        episode, step, action = found["episode"], found["step"], found["action"]
        known = self._actions.get(episode, []) if isinstance(episode, str) else None
        if known is None or step != len(known) or type(action) is not int or not 0 <= action <= 6:
            return False
        self._actions[episode] = [*known, action]
        return True

    def of(self, episode: str) -> tuple[int, ...]:
        """Actions of an episode so far.

        Args:
            episode: its id.
        """
        return tuple(self._actions.get(episode, ()))

    def add(self, episode: str, action: int) -> None:
        """Store an action, before it is carried out.

        Args:
            episode: its id.
            action: 0 to 6.

        Raises:
            DataError: it cannot be written; the action does not count then.
        """
        known = self._actions.setdefault(episode, [])
        line = (canonical_json({"episode": episode, "step": len(known), "action": action}) + "\n").encode()
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            try:
                _append(handle, line)
            finally:
                os.close(handle)
        except OSError as error:
            raise DataError(f"{self._path}: {error.strerror}; make room or fix permissions, then go on") from None
        known.append(action)


def _append(handle: int, line: bytes) -> None:
    """Write a whole line at the end of a file, or nothing: after part of a line, no later one could be read."""
    size = os.fstat(handle).st_size
    try:
        if os.write(handle, line) != len(line):
            raise OSError(errno.ENOSPC, "no room left")
    except OSError:
        os.ftruncate(handle, size)
        raise
