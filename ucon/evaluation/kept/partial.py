"""The file of an unfinished run: a line for each finished episode, each with a checksum before it.

The first line names the run; the other lines' checksums include its checksum, so a line of another run does not count.
A damaged line costs only the episode that it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.typed import parse_line, read_as
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.finished import as_played
from ucon.evaluation.kept.record import EpisodeRecord, EpisodeTiming
from ucon.evaluation.playing.play import PlayedEpisode

#: Longest first line in bytes.
_LONGEST: Final = 1 << 16
#: Largest file in bytes: some hundred thousand episodes, at 9 kB of decisions each.
_MAX_BYTES: Final = 1 << 30
#: Length of a checksum in characters.
_CHECKSUM: Final = 64


@dataclass(frozen=True)
class _Line:
    """A line's entries apart from record, timing and decisions."""

    index: int
    seconds: float
    """Seconds of the run when this episode was finished."""


@dataclass(frozen=True)
class PartialRun:
    """Content of an unfinished run's file."""

    header: dict[str, Any] | None
    """First line; None where nothing was written yet."""
    done: dict[int, PlayedEpisode]
    """Finished episodes by index."""
    seconds: float
    """Seconds of the run until its last readable episode."""
    damaged: int
    """Number of lines that were left out."""
    whole: bytes
    """The file without the damaged lines."""


def line_of(value: Mapping[str, Any], first: bytes = b"") -> bytes:
    """A line: checksum, space, JSON, line break.

    Args:
        value: content.
        first: the first line; empty for the first line itself.
    """
    body = canonical_json(value).encode()
    return f"{_checksum(body, first)} ".encode() + body + b"\n"


def line_of_played(played: PlayedEpisode, seconds: float, first: bytes) -> bytes:
    """The line of a finished episode.

    Args:
        played: the episode.
        seconds: of the run so far.
        first: the first line of the file.
    """
    value: dict[str, Any] = {
        "index": played.index,
        "seconds": round(float(seconds), 3),
        "record": played.record.to_json(),
        "timing": asdict(played.timing),
        "decisions": [d.to_json() for d in played.decisions],
    }
    return line_of(value, first)


def read_partial(path: Path, episodes: Sequence[str]) -> PartialRun:
    """Read all undamaged lines.

    Args:
        path: the file.
        episodes: ids of the episodes to play, in order.

    Raises:
        DataError: the first line is damaged.
    """
    raw = read_plain(path, _MAX_BYTES)
    lines = [line + b"\n" for line in raw.split(b"\n")[:-1]]  # the rest, if any, was cut off while being written
    header = _value(lines[0], path) if lines else None
    done: dict[int, PlayedEpisode] = {}
    seconds, kept = 0.0, lines[:1]
    for number, line in enumerate(lines[1:], 2):
        try:
            played, seconds_then = _played(_value(line, path, lines[0]), f"{path}:{number}", episodes, done)
        except DataError:
            continue
        done[played.index], seconds = played, max(seconds, seconds_then)
        kept.append(line)
    return PartialRun(header, done, seconds, len(lines) - len(kept), b"".join(kept))


def read_header(path: Path) -> dict[str, Any]:
    """Content of the first line, which names the run.

    Raises:
        DataError: it is damaged.
    """
    with path.open("rb") as file:
        return _value(file.readline(_LONGEST), path)


def _checksum(body: bytes, first: bytes) -> str:
    return sha256_bytes(first[:_CHECKSUM] + body)


def _value(line: bytes, path: Path, first: bytes = b"") -> dict[str, Any]:
    """Content of a line whose checksum is right.

    Raises:
        DataError: the checksum is wrong, or the line holds no object.
    """
    checksum, _, body = line.removesuffix(b"\n").partition(b" ")
    value = parse_line(body, str(path)) if checksum == _checksum(body, first).encode() else None
    if not isinstance(value, dict):
        raise DataError(
            f"{path}: its first line is damaged or from an older version; remove the folder or choose another"
        )
    return value


def _played(
    value: dict[str, Any], where: str, episodes: Sequence[str], done: Mapping[int, PlayedEpisode]
) -> tuple[PlayedEpisode, float]:
    """The episode in a line, and the seconds of the run when it ended.

    Raises:
        DataError: it is damaged, not one of these episodes, or in ``done`` already.
    """
    parts = {name: value.pop(name, None) for name in ("record", "timing", "decisions")}
    line = read_as(_Line, value, where, "an episode's line")
    record = EpisodeRecord.from_json(parts["record"], where=where)
    timing = EpisodeTiming.from_json(parts["timing"], where=where)
    decisions = parts["decisions"] if isinstance(parts["decisions"], list) else [None]
    made = [DecisionRecord.from_json(one, where=where) for one in decisions]
    known = 0 <= line.index < len(episodes) and line.index not in done and episodes[line.index] == record.episode
    if not known or line.seconds < 0:
        raise DataError(f"{where}: episode {line.index} is not the expected one, or is listed twice")
    return as_played(line.index, record, timing, made, where), line.seconds
