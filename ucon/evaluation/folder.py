"""The folder of one evaluation: what it holds, and how an interrupted one goes on.

While a run lasts, finished episodes are appended to ``episodes.jsonl.partial``, whose first line names the run (its
hashes) and the versions that play it. The same command on the same folder continues there; another run in the folder
is refused. A finished run is only read.
"""

from __future__ import annotations

import json
import time
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import asdict, replace
from itertools import count
from pathlib import Path
from typing import Any, TextIO

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from ucon.core.errors import ConfigError, DataError
from ucon.core.files import canonical_json, write_atomic
from ucon.core.yaml_text import without_aliases
from ucon.evaluation.decisions import DecisionRecord
from ucon.evaluation.play import Played
from ucon.evaluation.record import EpisodeRecord, EpisodeTiming, read_records, to_lines

RECORDS, TIMING, SUMMARY, CONFIG = "episodes.jsonl", "timing.jsonl", "summary.json", "config.yaml"
DECISIONS = "decisions.jsonl"
PARTIAL = f"{RECORDS}.partial"
_ALTERED = "the file is altered, remove the folder and evaluate again"


class RunFolder:
    """One output folder, bound to the run whose hashes are given, and while it lasts to the versions that play it."""

    def __init__(self, path: Path, hashes: dict[str, str], versions: Mapping[str, str] | None = None) -> None:
        self.path = path
        self.hashes = hashes
        self.summary: dict[str, Any] | None = None
        """Of a finished run, once it is open."""
        self._versions = dict(versions or {})
        self._partial: TextIO | None = None
        self._seconds_before, self._opened = 0.0, time.perf_counter()

    @property
    def seconds(self) -> float:
        """Since the folder was opened, and those of interrupted calls before, up to the last episode of each."""
        return self._seconds_before + time.perf_counter() - self._opened

    def is_free(self) -> bool:
        """Whether nothing lies here, or what an equal run left when it was interrupted."""
        if (self.path / PARTIAL).is_file() and not (self.path / SUMMARY).exists():
            return self._begun_here()
        return not self.path.exists() or (self.path.is_dir() and not any(self.path.iterdir()))

    def open(self) -> dict[int, Played]:
        """Make the folder and return the episodes that an earlier, equal run finished, by index.

        Raises:
            ConfigError: the folder belongs to a different run, or cannot be written.
        """
        summary = self.path / SUMMARY
        if summary.is_file():
            self.summary = _json(summary)
            found = self.summary.get("hashes")
            self._refuse_other(self.hashes, found, SUMMARY)
            self.hashes = dict(found or {})  # it knows weights that may be gone by now
            return self._finished()
        self._refuse_what_it_would_overwrite()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            done = self._read_partial()
            self._partial = (self.path / PARTIAL).open("a", encoding="utf-8")
        except OSError as error:
            raise ConfigError(f"out={self.path}: cannot be written ({error.strerror}); choose another folder") from None
        if self._partial.tell() == 0:
            self._append({"hashes": self.hashes, "versions": self._versions})
        self._opened = time.perf_counter()
        return done

    def add(self, played: Played) -> None:
        """Keep a finished episode, so that it survives an interruption."""
        timing = asdict(played.timing)
        record, seconds = json.loads(played.record.to_line()), round(self.seconds, 3)
        line = {"index": played.index, "record": record, "timing": timing, "seconds": seconds}
        if played.decisions:
            line["decisions"] = [json.loads(d.to_line()) for d in played.decisions]
        self._append(line)

    def finish(self, played: list[Played], summary: dict[str, Any], config_yaml: str) -> None:
        """Write the final files and remove the partial one. ``summary.json`` comes last: it says that all is there."""
        if self._partial is not None:
            self._partial.close()
        write_atomic(self.path / RECORDS, to_lines(p.record for p in played))
        write_atomic(self.path / TIMING, to_lines(p.timing for p in played))
        decisions = [d for p in played for d in p.decisions]
        if decisions:
            write_atomic(self.path / DECISIONS, "".join(f"{d.to_line()}\n" for d in decisions))
        write_atomic(self.path / CONFIG, config_yaml)
        write_atomic(self.path / SUMMARY, json.dumps(summary, indent=1) + "\n")
        (self.path / PARTIAL).unlink(missing_ok=True)

    def _append(self, value: dict[str, Any]) -> None:
        if self._partial is not None:
            self._partial.write(canonical_json(value) + "\n")
            self._partial.flush()

    def _finished(self) -> dict[int, Played]:
        records = read_records(self.path)
        timings = [
            EpisodeTiming.from_json(_parsed(line, where), where=where) for line, where in _numbered(self.path / TIMING)
        ]
        made: dict[str, list[DecisionRecord]] = defaultdict(list)
        for line, where in _numbered(self.path / DECISIONS):
            decision = DecisionRecord.from_json(_parsed(line, where), where=where)
            made[decision.episode].append(decision)
        if len(timings) != len(records):
            raise DataError(f"{self.path / TIMING}: {len(timings)} lines for {len(records)} episodes; {_ALTERED}")
        pairs = enumerate(zip(records, timings, strict=True))
        where = str(self.path / DECISIONS)
        return {i: _played(i, record, timing, made[record.episode], where) for i, (record, timing) in pairs}

    def _read_partial(self) -> dict[int, Played]:
        partial = self.path / PARTIAL
        if not partial.is_file():
            return {}
        text = partial.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        if whole != text:  # the last line was cut off in mid-write: that episode is played again
            write_atomic(partial, whole)
        lines = whole.splitlines()
        if not lines:
            return {}
        self._refuse_other(self._named, _names(lines[0], f"{partial}:1"), PARTIAL)
        done = {}
        for number, line in enumerate(lines[1:], 2):
            where = f"{partial}:{number}"
            value = _parsed(line, where)
            try:
                index, self._seconds_before = int(value["index"]), float(value["seconds"])
            except (KeyError, TypeError, ValueError):
                raise DataError(f"{where}: no episode with its index and seconds; {_ALTERED}") from None
            record = EpisodeRecord.from_json(value.get("record", {}), where=where)
            timing = EpisodeTiming.from_json(value.get("timing", {}), where=where)
            decisions = [DecisionRecord.from_json(d, where=where) for d in value.get("decisions", [])]
            done[index] = _played(index, record, timing, decisions, where)
        return done

    @property
    def _named(self) -> dict[str, Any]:
        """What an unfinished run must have in common with this one: other versions might play the rest otherwise."""
        return {**self.hashes, "versions": self._versions}

    def _begun_here(self) -> bool:
        partial = self.path / PARTIAL
        with partial.open(encoding="utf-8", errors="replace") as file:
            try:
                return not _different(self._named, _names(file.readline(), f"{partial}:1"))
            except DataError:
                return False

    def _refuse_other(self, wanted: Mapping[str, Any], found: Any, name: str) -> None:
        if other := _different(wanted, found):
            raise ConfigError(
                f"out={self.path}: {name} there belongs to another run (different {', '.join(other)}); "
                "choose another folder or remove this one"
            )

    def _refuse_what_it_would_overwrite(self) -> None:
        """Without a summary or a partial file, results are not those of a run that could go on: of training, say."""
        if (self.path / PARTIAL).is_file():
            return
        there = sorted(p.name for pattern in (CONFIG, f"{RECORDS}*") for p in self.path.glob(pattern))
        if there:
            raise ConfigError(
                f"out={self.path}: {there[0]} there is of another run and would be overwritten; choose another folder"
            )


def free_folder(out: Path, hashes: dict[str, str], versions: Mapping[str, str]) -> Path:
    """The first of ``out``, ``out-2``, ``out-3``, ... where this run can be played without touching another one."""
    names = (out.name if number == 1 else f"{out.name}-{number}" for number in count(1))
    return next(path for name in names if RunFolder(path := out.with_name(name), hashes, versions).is_free())


def read_config(folder: Path) -> dict[str, Any]:
    """The configuration of a finished run.

    Raises:
        DataError: there is none, or it is damaged.
    """
    path = folder / CONFIG
    if not path.is_file():
        raise DataError(f"{path}: no such file; expected the folder of a finished run of eval.py")
    try:
        config = OmegaConf.to_container(OmegaConf.create(without_aliases(path.read_text(encoding="utf-8"))))
    except (OSError, ValueError, YAMLError, OmegaConfBaseException, RecursionError):
        config = None
    if not isinstance(config, dict) or not {"env", "task", "episodes"} <= config.keys():
        raise DataError(f"{path}: no configuration of a run; {_ALTERED}")
    return {str(name): value for name, value in config.items()}


def _played(index: int, record: EpisodeRecord, timing: EpisodeTiming, made: list[DecisionRecord], where: str) -> Played:
    """An episode as it was when it ended: decisions get their seconds back from the timing."""
    seconds = timing.decision_seconds or (0.0,) * len(made)
    if len(seconds) != len(made):
        raise DataError(f"{where}: {len(made)} decisions in {record.episode}, expected {len(seconds)}; {_ALTERED}")
    return Played(index, record, timing, tuple(replace(d, seconds=s) for d, s in zip(made, seconds, strict=True)))


def _names(line: str, where: str) -> dict[str, Any]:
    """What the first line of a partial file says of its run."""
    header = _parsed(line, where)
    hashes = header.get("hashes")
    return {**(hashes if isinstance(hashes, dict) else {}), "versions": header.get("versions")}


def _different(wanted: Mapping[str, Any], found: Any) -> list[str]:
    """Names of what is not as wanted."""
    known = found if isinstance(found, dict) else {}
    return sorted(name for name in wanted if known.get(name) != wanted[name])


def _numbered(path: Path) -> list[tuple[str, str]]:
    """Lines of a file and where each stands; none where there is no file."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    return [(line, f"{path}:{number}") for number, line in enumerate(lines, 1)]


def _json(path: Path) -> dict[str, Any]:
    return _parsed(path.read_text(encoding="utf-8"), str(path))


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        value = json.loads(text)
    except ValueError:
        raise DataError(f"{where}: not JSON; {_ALTERED}") from None
    return value if isinstance(value, dict) else {}
