"""The output folder of one evaluation, and how an interrupted one continues.

While a run lasts, finished episodes are appended to ``episodes.jsonl.partial``, whose first line has the run's hashes
and versions. The same command on the same folder continues there; another run in that folder is refused. A finished run
is only read.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any, BinaryIO

from ucon.core.errors import ConfigError, DataError
from ucon.core.files import write_atomic
from ucon.evaluation.figures.report import seconds_of
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.partial import line_of, line_of_played, read_header, read_partial
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.kept.seal import (
    CONFIG,
    DECISIONS,
    PARTIAL,
    RECORDS,
    SEALED,
    SECONDS,
    SUMMARY,
    TIMING,
    has_summary,
    sealed,
)
from ucon.evaluation.playing.play import PlayedEpisode


class RunFolder:
    """One output folder for the run with the given hashes.

    Args:
        path: the folder; it need not exist.
        hashes: of the run; a folder of a run with other hashes is refused.
        versions: of packages; while the run is unfinished, other versions are refused too.
    """

    def __init__(self, path: Path, hashes: dict[str, str], versions: Mapping[str, str] | None = None) -> None:
        self.path = path
        self.hashes = hashes
        self.summary: dict[str, Any] | None = None
        """Content of ``summary.json`` if the run is finished already; set by :meth:`open`."""
        self._versions = dict(versions or {})
        self._first = b""
        self.damaged = 0
        """Number of damaged lines in the partial file; their episodes are played again."""
        self._partial: BinaryIO | None = None
        self._seconds_before, self._opened = 0.0, time.perf_counter()

    @property
    def seconds(self) -> float:
        """Seconds since the folder was opened, plus those of earlier, interrupted calls.

        Each earlier call counts up to its last finished episode.
        """
        return self._seconds_before + time.perf_counter() - self._opened

    def is_free(self) -> bool:
        """Whether the folder is empty, missing, or holds the unfinished part of this same run."""
        if (self.path / PARTIAL).is_file() and not (self.path / SUMMARY).exists():
            return self._begun_here()
        return not self.path.exists() or (self.path.is_dir() and not any(self.path.iterdir()))

    def open(self, episodes: Sequence[str]) -> dict[int, PlayedEpisode]:
        """Create the folder, or continue what an earlier, equal run left.

        Args:
            episodes: ids of the episodes to play, in order.

        Returns:
            Episodes that are finished already, by index.

        Raises:
            ConfigError: the folder belongs to a different run, or cannot be written.
            DataError: its content is damaged.
        """
        if has_summary(self.path):
            return self._finished(episodes)
        self._refuse_what_it_would_overwrite()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            done = self._read_partial(episodes)
            self._partial = (self.path / PARTIAL).open("ab")
        except OSError as error:
            raise ConfigError(f"out={self.path}: cannot be written ({error.strerror}); choose another folder") from None
        if self._partial.tell() == 0:
            self._first = line_of({"hashes": self.hashes, "versions": self._versions, "n": len(episodes)})
            self._append(self._first)
        self._opened = time.perf_counter()
        return done

    def add(self, played: PlayedEpisode) -> None:
        """Append a finished episode to the partial file, so that it survives an interruption."""
        self._append(line_of_played(played, self.seconds, self._first))

    def finish(self, played: Sequence[PlayedEpisode], summary: Mapping[str, Any], config_yaml: str) -> None:
        """Write the final files and remove the partial one.

        ``summary.json`` is written last: it marks the run as complete.

        Args:
            played: all episodes, in order.
            summary: content of ``summary.json``.
            config_yaml: text of ``config.yaml``.
        """
        if self._partial is not None:
            self._partial.close()
        decisions = "".join(f"{d.to_line()}\n" for p in played for d in p.decisions)
        texts = {
            RECORDS: to_lines(p.record for p in played),
            TIMING: to_lines(p.timing for p in played),
            CONFIG: config_yaml,
        } | ({DECISIONS: decisions} if decisions else {})
        content = {name: text.encode() for name, text in texts.items()}
        said: Mapping[str, Any] = {SECONDS: seconds_of(played, self.seconds), SUMMARY: summary}
        content |= {
            name: sealed(said[name], {part: content[part] for part in SEALED[name] if part in content}).encode()
            for name in (SECONDS, SUMMARY)
        }
        for name, data in content.items():
            write_atomic(self.path / name, data)
        (self.path / PARTIAL).unlink(missing_ok=True)

    def _append(self, line: bytes) -> None:
        if self._partial is not None:
            self._partial.write(line)
            self._partial.flush()

    def _finished(self, episodes: Sequence[str]) -> dict[int, PlayedEpisode]:
        run = FinishedRun.read(self.path)
        found = run.summary["hashes"]
        self._refuse_other(self.hashes, found, SUMMARY)
        played = run.played()
        if [played[i].record.episode for i in range(len(played))] != list(episodes):
            raise DataError(
                f"{self.path}: a finished run, but its configuration now names other episodes; remove the folder "
                "and evaluate again"
            )
        self.summary, self.hashes = run.summary, dict(found)  # includes the hash of weights that may be missing by now
        return played

    def _read_partial(self, episodes: Sequence[str]) -> dict[int, PlayedEpisode]:
        partial = self.path / PARTIAL
        if not partial.is_file():
            return {}
        left = read_partial(partial, episodes)
        if left.header is not None:
            self._refuse_other(self._named, _names(left.header), PARTIAL)
            self._first = left.whole[: left.whole.index(b"\n") + 1]
        if len(left.whole) != partial.stat().st_size:
            write_atomic(partial, left.whole)
        self._seconds_before, self.damaged = left.seconds, left.damaged
        return left.done

    @property
    def _named(self) -> dict[str, Any]:
        """What an unfinished run must have in common with this one; other versions might play the rest differently."""
        return {**self.hashes, "versions": self._versions}

    def _begun_here(self) -> bool:
        try:
            return not _different(self._named, _names(read_header(self.path / PARTIAL)))
        except DataError:
            return False

    def _refuse_other(self, wanted: Mapping[str, Any], found: Any, name: str) -> None:
        if other := _different(wanted, found):
            raise ConfigError(
                f"out={self.path}: {name} there belongs to another run (different {', '.join(other)}); "
                "choose another folder or remove this one"
            )

    def _refuse_what_it_would_overwrite(self) -> None:
        """Refuse a folder with results but neither summary nor partial file, such as one of training."""
        if (self.path / PARTIAL).is_file():
            return
        there = sorted(p.name for pattern in (CONFIG, f"{RECORDS}*") for p in self.path.glob(pattern))
        if there:
            raise ConfigError(
                f"out={self.path}: {there[0]} belongs to another run and would be overwritten; choose another folder"
            )


def free_folder(out: Path, hashes: dict[str, str], versions: Mapping[str, str]) -> Path:
    """The first of ``out``, ``out-2``, ``out-3``, ... where this run can be played without touching another one.

    Args:
        out: wanted folder.
        hashes: of the run.
        versions: of packages.
    """
    names = (out.name if number == 1 else f"{out.name}-{number}" for number in count(1))
    return next(path for name in names if RunFolder(path := out.with_name(name), hashes, versions).is_free())


def _names(header: Mapping[str, Any]) -> dict[str, Any]:
    """Hashes and versions in the first line of a partial file."""
    hashes = header.get("hashes")
    return {**(hashes if isinstance(hashes, dict) else {}), "versions": header.get("versions")}


def _different(wanted: Mapping[str, Any], found: Any) -> list[str]:
    """Names of the entries that differ."""
    known = found if isinstance(found, dict) else {}
    return sorted(name for name in wanted if known.get(name) != wanted[name])
