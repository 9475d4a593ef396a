"""Reads files that grow while another process writes them: only what is new is read."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

#: Largest number of files whose lines are kept, of bytes that are read at once, and of bytes in a line.
_MOST_FILES, _MOST_READ, _LONGEST = 64, 1 << 28, 1 << 24
_START: Final = 256


@dataclass
class _Tail:
    """What was read of one file."""

    start: bytes = b""
    offset: int = 0
    values: list[Any] = field(default_factory=list)


class Tails:
    """The lines of growing files as values; invalid lines are left out."""

    def __init__(self, read: Callable[[bytes], Any]) -> None:
        """Files of one kind.

        Args:
            read: gives the value of a line without its line break; None for an invalid line.
        """
        self._read = read
        self._tails: OrderedDict[Path, _Tail] = OrderedDict()
        self._lock = threading.Lock()

    def lines(self, path: Path) -> list[Any]:
        """Values of all whole lines that are there now.

        Args:
            path: of the file; one that is shorter or begins differently than before is read again from the start.

        Raises:
            OSError: it cannot be read.
        """
        with self._lock, path.open("rb") as file:
            start = file.read(_START)
            tail = self._tails.get(path)
            size = file.seek(0, 2)
            if tail is None or size < tail.offset or not start.startswith(tail.start):
                tail = self._tails[path] = _Tail()
            tail.start = start
            file.seek(tail.offset)
            new = file.read(_MOST_READ)
            whole = new[: new.rfind(b"\n") + 1]
            tail.offset += len(whole)
            found = (self._read(line) for line in whole.split(b"\n")[:-1] if len(line) <= _LONGEST)
            tail.values.extend(value for value in found if value is not None)
            self._tails.move_to_end(path)
            while len(self._tails) > _MOST_FILES:
                self._tails.popitem(last=False)
            return list(tail.values)
