"""What is kept of one episode: one JSON line, the same bytes in every run, whatever the workers and their order.

Wall-clock seconds differ between runs, so they live in :class:`EpisodeTiming`, written to a file of their own.
"""

from __future__ import annotations

import json
import lzma
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from ucon.core.errors import DataError
from ucon.core.files import canonical_json

#: Digits kept of every figure: enough for any table, few enough to hide nothing that could differ.
_DIGITS = 6
#: Of the records of one run, unpacked: some hundred thousand episodes.
_MAX_BYTES = 1 << 28


@dataclass(frozen=True)
class EpisodeRecord:
    """One evaluated episode. Lengths in metres, ``first_seen_step`` -1 where the target was never visible."""

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
    """The actions taken, as digits 0 to 6: replaying them replays the episode."""
    opens: int
    collisions: int
    first_seen_step: int
    failure_cause: str
    """``none`` or one of :data:`ucon.task.outcome.FailureCause`."""
    n_habits: int
    recall_10: float | None
    """Share of the target's habits among the first 10 that the agent was given; None without habits."""
    recall_20: float | None
    mrr: float | None
    """One over the rank of the first habit about the target."""
    language_calls: int = 0
    language_tokens: int = 0

    def to_line(self) -> str:
        """One line of canonical JSON without the line break."""
        return canonical_json({k: _rounded(v) for k, v in asdict(self).items()})

    @classmethod
    def from_json(cls, data: dict[str, Any], *, where: str = "record") -> EpisodeRecord:
        """Rebuild a record; raises :class:`DataError` where a field is missing or unknown."""
        names = {f.name for f in fields(cls)}
        if not isinstance(data, dict) or set(data) != names:
            found = set(data) if isinstance(data, dict) else set()
            missing, extra = sorted(names - found), sorted(found - names)
            raise DataError(
                f"{where}: not an episode record (missing {missing or 'nothing'}, unknown {extra or 'nothing'}); "
                "was it written by another version? evaluate again"
            )
        return cls(**data)


@dataclass(frozen=True)
class EpisodeTiming:
    """How long an episode took. Kept apart from the record because it differs from run to run."""

    episode: str
    seconds: float
    language_seconds: float = 0.0
    decision_seconds: tuple[float, ...] = ()
    """Of the answers to each decision, for agents that ask a language model."""

    def to_line(self) -> str:
        """One line of canonical JSON without the line break."""
        return canonical_json(asdict(self))

    @classmethod
    def from_json(cls, data: dict[str, Any], *, where: str = "timing") -> EpisodeTiming:
        """Rebuild a timing from a parsed line; raises :class:`DataError` where it is none."""
        try:
            return cls(**{**data, "decision_seconds": tuple(data.get("decision_seconds", ()))})
        except (TypeError, AttributeError):
            raise DataError(f"{where}: not an episode's timing; the file is altered, evaluate again") from None


def read_records(path: Path) -> list[EpisodeRecord]:
    """Records of ``episodes.jsonl``, or of the folder that holds it: a run's, or one of ``results/`` (``.xz``).

    Raises:
        DataError: the file is missing, empty, not whole, or a line is not a record; names file and line.
    """
    file = path / "episodes.jsonl" if path.is_dir() else path
    packed = file.with_name(f"{file.name}.xz") if path.is_dir() and not file.is_file() else file
    if not packed.is_file():
        raise DataError(f"{file}: no such file; expected a run folder of eval.py (with episodes.jsonl)")
    text = _unpacked(packed) if packed.suffix == ".xz" else packed.read_text()
    records = [_parse(line, f"{packed}:{number}") for number, line in enumerate(text.splitlines(), 1)]
    if not records:
        raise DataError(f"{file}: empty; expected one record a line, evaluate again")
    return records


def to_lines(items: Iterable[EpisodeRecord | EpisodeTiming]) -> str:
    """Text of a JSON lines file."""
    return "".join(f"{item.to_line()}\n" for item in items)


def _unpacked(file: Path) -> str:
    unpacker = lzma.LZMADecompressor()
    try:
        text = unpacker.decompress(file.read_bytes(), max_length=_MAX_BYTES).decode()
        problem = "" if unpacker.eof else "it ends too early, or is larger than any run"
    except (lzma.LZMAError, EOFError, UnicodeDecodeError) as error:
        problem = str(error)
    if problem:
        raise DataError(f"{file}: not whole ({problem}); restore it or evaluate again")
    return text


def _parse(line: str, where: str) -> EpisodeRecord:
    try:
        data = json.loads(line)
    except ValueError:
        raise DataError(f"{where}: not JSON; the file is cut off or altered, evaluate again") from None
    return EpisodeRecord.from_json(data, where=where)


def _rounded(value: Any) -> Any:
    return round(value, _DIGITS) + 0.0 if isinstance(value, float) else value
