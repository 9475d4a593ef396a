"""The record of one episode: one JSON line, with the same bytes in every run, for any number and order of workers.

Wall-clock seconds differ between runs, so they are in :class:`EpisodeTiming`, in a file of their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, get_args

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json
from ucon.core.untrusted.typed import parse_line, read_as
from ucon.evaluation.kept.seal import RECORDS, has_summary, read_bytes, read_file, read_files, refuse_unfinished
from ucon.lives.request_record import BelievedPlace, LifeFacts
from ucon.retrieval.levels import LEVELS
from ucon.task.outcome import FailureCause

#: Digits to which every figure is rounded: enough for any table.
_DIGITS: Final = 6
#: Fields that are left out of the file where they are None.
_OPTIONAL: Final = ("life", "believed")
_FAILURES: Final = get_args(FailureCause)
_SHARES: Final = ("spl", "soft_spl", "recall_10", "recall_20", "mrr")
_COUNTS: Final = ("opens", "collisions", "n_habits", "language_calls", "language_tokens")


@dataclass(frozen=True)
class EpisodeRecord:
    """One evaluated episode. Lengths are in metres; ``first_seen_step`` is -1 if the target was never visible.

    Figures are rounded as they are stored, so that everything computed from them is the same before and after.
    """

    episode: str
    scene: str
    split: str
    target: str
    relation: str
    contained: bool
    """Whether the target was behind a closed door."""
    agent: str
    habit_level: str
    seed: int
    success: bool
    success_75: bool
    success_150: bool
    success_300: bool
    spl: float
    soft_spl: float
    shortest_path_m: float
    path_length_m: float
    steps: int
    actions: str
    """The actions taken, as digits 0 to 6; taking them again replays the episode."""
    opens: int
    collisions: int
    first_seen_step: int
    failure_cause: str
    """``none`` or one of :data:`ucon.task.outcome.FailureCause`."""
    n_habits: int
    recall_10: float | None
    """Share of the target's habits among the first 10 given habits; None at levels that do not rank."""
    recall_20: float | None
    mrr: float | None
    """Reciprocal rank of the first habit about the target."""
    language_calls: int = 0
    language_tokens: int = 0
    life: LifeFacts | None = None
    """Facts about a request within its life; None, and then not in the file, for an episode."""
    believed: tuple[BelievedPlace, ...] | None = None
    """Places where a robot with a memory believed the target to be, the likeliest first; None, and then not in the
    file, for a robot that remembers no places."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, float):
                object.__setattr__(self, name, round(float(value), _DIGITS) + 0.0)

    def to_line(self) -> str:
        """One line of canonical JSON, without the line break."""
        return canonical_json(self.to_json())

    def to_json(self) -> dict[str, Any]:
        """The record as JSON data."""
        data = asdict(self)
        return {name: value for name, value in data.items() if name not in _OPTIONAL or value is not None}

    @classmethod
    def from_json(cls, data: Any, *, where: str = "record") -> EpisodeRecord:
        """Read a record.

        Args:
            data: plain values; not trusted.
            where: file and line, for errors.

        Raises:
            DataError: it is malformed, or contradicts itself.
        """
        without = tuple(name for name in _OPTIONAL if isinstance(data, dict) and name not in data)
        record = read_as(cls, data, where, "an episode record", without=without)
        if problem := next(_contradictions(record), None):
            raise DataError(f"{where}: {problem}; the file is altered, evaluate again")
        return record


@dataclass(frozen=True)
class EpisodeTiming:
    """Wall-clock seconds of an episode; kept apart from the record because they differ from run to run."""

    episode: str
    seconds: float
    language_seconds: float = 0.0
    decision_seconds: tuple[float, ...] = ()
    """Seconds of the answers to each decision, for agents that ask a language model."""

    def to_line(self) -> str:
        """One line of canonical JSON, without the line break."""
        return canonical_json(asdict(self))

    @classmethod
    def from_json(cls, data: Any, *, where: str = "timing") -> EpisodeTiming:
        """Read a timing from a parsed line.

        Args:
            data: plain values; not trusted.
            where: file and line, for errors.

        Raises:
            DataError: it is malformed, or has negative seconds.
        """
        timing = read_as(cls, data, where, "an episode's timing")
        if min(timing.seconds, timing.language_seconds, *timing.decision_seconds) < 0:
            raise DataError(f"{where}: seconds below 0; the file is altered, evaluate again")
        return timing


def read_records(path: Path) -> list[EpisodeRecord]:
    """Read records; with a ``summary.json`` next to them, their checksum is verified.

    Args:
        path: ``episodes.jsonl`` (or ``.xz``), or the folder that holds it.

    Raises:
        DataError: the file is missing, empty, truncated, or a line is no record; names file and line.
    """
    folder, name = (path, RECORDS) if path.is_dir() else (path.parent, path.name)
    if name in (RECORDS, f"{RECORDS}.xz") and has_summary(folder):
        raw = read_files(folder).content.get(RECORDS)
    else:
        raw = read_file(folder, name) if path.is_dir() else read_bytes(path) if path.is_file() else None
    if raw is None:
        refuse_unfinished(folder)
        raise DataError(f"{folder / name}: no such file; expected a run folder of eval.py (with {RECORDS})")
    return parse_records(raw, folder / name)


def parse_records(raw: bytes, path: Path) -> list[EpisodeRecord]:
    """Records of a file with one record per line.

    Args:
        raw: content of the file.
        path: of the file, for errors.

    Raises:
        DataError: no records, a line that is no record, or an episode twice; names the line.
    """
    records = [EpisodeRecord.from_json(value, where=where) for value, where in json_lines(raw, path)]
    if not records:
        raise DataError(f"{path}: empty; expected one record per line, evaluate again")
    seen: set[str] = set()
    for number, record in enumerate(records, 1):
        if record.episode in seen:
            raise DataError(f"{path}:{number}: episode {brief(record.episode)} is listed twice; evaluate again")
        seen.add(record.episode)
    return records


def json_lines(raw: bytes, path: Path) -> Iterator[tuple[Any, str]]:
    """Value of every line of a file, with file and line number.

    Args:
        raw: content of the file.
        path: of the file, for errors.

    Raises:
        DataError: a line is not JSON, or the last one has no line break.
    """
    lines = raw.split(b"\n")
    for number, line in enumerate(lines[:-1], 1):
        yield parse_line(line, f"{path}:{number}", "the file is cut off or altered, evaluate again"), f"{path}:{number}"
    if lines[-1]:
        raise DataError(f"{path}:{len(lines)}: not JSON with a line break; the file is cut off, evaluate again")


def to_lines(items: Iterable[EpisodeRecord | EpisodeTiming]) -> str:
    """Text of a JSON lines file."""
    return "".join(f"{item.to_line()}\n" for item in items)


def episode_spl(success: bool, shortest_path_m: float, path_length_m: float) -> float:
    """SPL of one episode: shortest path over the longer of both paths, 0 for a failure.

    Args:
        success: whether it succeeded.
        shortest_path_m: shortest path in metres.
        path_length_m: length of the successful moves in metres.
    """
    return shortest_path_m / max(path_length_m, shortest_path_m, 1e-9) if success else 0.0


def _contradictions(record: EpisodeRecord) -> Iterator[str]:
    """Contradictions within a record, in words."""
    steps = record.steps
    if len(record.actions) != steps or record.actions.strip("0123456"):
        yield f"actions={brief(record.actions)}: expected {steps} digits from 0 to 6"
    for limit in (75, 150, 300):
        if getattr(record, f"success_{limit}") != (record.success and steps <= limit):
            yield f"success_{limit} contradicts success={record.success} in {steps} steps"
    believed = {f"believed[{k}].p": place.p for k, place in enumerate(record.believed or ())}
    for name, value in ({name: getattr(record, name) for name in _SHARES} | believed).items():
        if value is not None and not 0 <= value <= 1:
            yield f"{name}={value}: expected a number from 0 to 1"
    if min(record.shortest_path_m, record.path_length_m) < 0:
        yield "a path shorter than 0 metres"
    if abs(episode_spl(record.success, record.shortest_path_m, record.path_length_m) - record.spl) > 1e-5:
        yield f"spl={record.spl} contradicts its success and lengths"
    if any(getattr(record, name) < 0 for name in _COUNTS) or max(record.opens, record.collisions) > steps:
        yield "counts below 0 or above the number of steps"
    if not -1 <= record.first_seen_step <= steps:
        yield f"first_seen_step={record.first_seen_step}: expected -1 to {steps}"
    if record.failure_cause not in _FAILURES or (record.failure_cause == "none") != record.success:
        yield f"failure_cause={brief(record.failure_cause)}: not a cause for an episode with success={record.success}"
    if record.habit_level not in LEVELS:
        yield f"habit_level={brief(record.habit_level)}: expected one of {', '.join(LEVELS)}"
