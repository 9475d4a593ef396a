"""The folder of one evaluation: what it holds, and how an interrupted one goes on.

While a run lasts, finished episodes are appended to ``episodes.jsonl.partial``, whose first line names the run (its
hashes). The same command on the same folder continues there; another run in the folder is refused.
"""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TextIO

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from ucon.core.errors import ConfigError, DataError
from ucon.core.files import canonical_json, write_atomic
from ucon.evaluation.decisions import DecisionRecord
from ucon.evaluation.play import Played
from ucon.evaluation.record import EpisodeRecord, EpisodeTiming, read_records, to_lines

RECORDS, TIMING, SUMMARY, CONFIG = "episodes.jsonl", "timing.jsonl", "summary.json", "config.yaml"
DECISIONS = "decisions.jsonl"
PARTIAL = f"{RECORDS}.partial"
_ALTERED = "the file is altered, remove the folder and evaluate again"


class RunFolder:
    """One output folder, bound to the run whose hashes are given."""

    def __init__(self, path: Path, hashes: dict[str, str]) -> None:
        self.path = path
        self.hashes = hashes
        self._partial: TextIO | None = None

    def open(self) -> dict[int, Played]:
        """Make the folder and return the episodes that an earlier, equal run finished, by index.

        Raises:
            ConfigError: the folder belongs to a different run, or cannot be written.
        """
        summary = self.path / SUMMARY
        if summary.is_file():
            found = _json(summary).get("hashes")
            self._refuse_other(found, SUMMARY)
            self.hashes = dict(found or {})  # it knows weights that may be gone by now
            return self._finished()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            done = self._read_partial()
            self._partial = (self.path / PARTIAL).open("a", encoding="utf-8")
        except OSError as error:
            raise ConfigError(f"out={self.path}: cannot be written ({error.strerror}); choose another folder") from None
        if self._partial.tell() == 0:
            self._append({"hashes": self.hashes})
        return done

    def add(self, played: Played) -> None:
        """Keep a finished episode, so that it survives an interruption."""
        timing = asdict(played.timing)
        line = {"index": played.index, "record": json.loads(played.record.to_line()), "timing": timing}
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
        self._refuse_other(_parsed(lines[0], f"{partial}:1").get("hashes"), PARTIAL)
        done = {}
        for number, line in enumerate(lines[1:], 2):
            where = f"{partial}:{number}"
            value = _parsed(line, where)
            record = EpisodeRecord.from_json(value.get("record", {}), where=where)
            timing = EpisodeTiming.from_json(value.get("timing", {}), where=where)
            decisions = [DecisionRecord.from_json(d, where=where) for d in value.get("decisions", [])]
            done[int(value["index"])] = _played(int(value["index"]), record, timing, decisions, where)
        return done

    def _refuse_other(self, found: Any, name: str) -> None:
        known = found if isinstance(found, dict) else {}
        other = sorted(k for k in self.hashes if known.get(k) != self.hashes[k])
        if not other:
            return
        raise ConfigError(
            f"out={self.path}: {name} there belongs to another run (different {', '.join(other)}); "
            "choose another folder or remove this one"
        )


def read_config(folder: Path) -> dict[str, Any]:
    """The configuration of a finished run.

    Raises:
        DataError: there is none, or it is damaged.
    """
    path = folder / CONFIG
    if not path.is_file():
        raise DataError(f"{path}: no such file; expected the folder of a finished run of eval.py")
    try:
        config = OmegaConf.to_container(OmegaConf.load(path))
    except (OSError, ValueError, YAMLError, OmegaConfBaseException):
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
