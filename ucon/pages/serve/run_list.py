"""Finds runs below some folders: of ``eval.py`` and ``train.py``, finished or not."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import sha256_bytes
from ucon.core.untrusted.strict_json import read_json
from ucon.evaluation.kept.seal import PARTIAL, RECORDS, SECONDS, SUMMARY
from ucon.learning.run.run_folder import METRICS

REPORT: Final = "report.html"
#: Largest summary in bytes.
MOST_SUMMARY: Final = 1 << 24
#: How deep below a folder runs are looked for, in how many folders at most, and which folders are skipped.
_DEEPEST, _MOST_FOLDERS = 4, 4000
_NO_RUNS: Final = frozenset({"checkpoints", "model", "pictures", "tensorboard", "wandb", "__pycache__"})
#: Seconds for which a list is used before the folders are read again.
_HOLDS_S: Final = 2.0


@dataclass(frozen=True)
class FoundRun:
    """A folder with a run in it."""

    id: str
    """Used in addresses in place of its path."""
    name: str
    path: Path
    kind: str
    """``eval`` or ``train``."""
    finished: bool
    written_s: float
    """When something was last written, seconds since 1970."""
    report: bool
    """Whether it has a report."""
    can_report: bool
    """Whether one can be made: its metrics or, of a finished evaluation, its records are here."""


class RunList:
    """The runs below some folders."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """Look for runs in these folders.

        Args:
            folders: absolute paths.
        """
        self._folders = tuple(dict.fromkeys(folders))
        self._runs: dict[str, FoundRun] = {}
        self._until = 0.0
        self._lock = threading.Lock()

    def all(self) -> list[FoundRun]:
        """All runs, those written last first."""
        with self._lock:
            if time.monotonic() > self._until:
                self._runs = {run.id: run for folder in self._folders for run in _runs_below(folder)}
                self._until = time.monotonic() + _HOLDS_S
            return sorted(self._runs.values(), key=lambda run: (-run.written_s, run.name))

    def get(self, number: str) -> FoundRun:
        """A run by its id.

        Args:
            number: the id.

        Raises:
            ConfigError: there is none.
        """
        found = next((run for run in self.all() if run.id == number), None)
        if found is None:
            raise ConfigError(f"run '{brief(number)}' no longer exists; choose another")
        return found


def _runs_below(top: Path) -> Iterator[FoundRun]:
    for seen, (folder, below, files) in enumerate(os.walk(top)):  # follows no links
        path = Path(folder)
        depth = len(path.relative_to(top).parts)
        below[:] = sorted(name for name in below if name not in _NO_RUNS and not name.startswith(".")) * (
            depth < _DEEPEST
        )
        if seen >= _MOST_FOLDERS:
            return
        if (run := _run(path, top, frozenset(files))) is not None:
            yield run


def _run(path: Path, top: Path, files: frozenset[str]) -> FoundRun | None:
    measured, finished = METRICS in files, SUMMARY in files
    if not measured and not finished and PARTIAL not in files:
        return None
    names = [name for name in (SUMMARY, PARTIAL, METRICS, RECORDS) if name in files]
    try:
        written_s = max((path / name).stat().st_mtime for name in names)
    except OSError:  # removed in between
        return None
    name = str(Path(top.name, path.relative_to(top)))
    trained = measured or (finished and SECONDS not in files and _is_of_training(path / SUMMARY))
    recorded = finished and not trained and not files.isdisjoint((RECORDS, f"{RECORDS}.xz"))
    return FoundRun(
        sha256_bytes(str(path).encode())[:16], name, path, "train" if trained else "eval", finished, written_s,
        REPORT in files, measured or recorded,
    )  # fmt: skip


def _is_of_training(path: Path) -> bool:
    """Whether a summary is of ``train.py``; of some training runs nothing else is kept, as in ``results/``."""
    try:
        said = read_json(path, "train again", max_bytes=MOST_SUMMARY)
    except DataError:
        return False
    return isinstance(said, dict) and isinstance(said.get("best"), dict)
