"""Sets of lives: compressed JSON lines, one life per line, verified against a SHA-256 manifest."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

from ucon.core.errors import EpisodeError, unknown_name
from ucon.lives.life import Life
from ucon.task.packed_lines import check_name, read_lines, write_lines

SUFFIX: Final = ".lives.xz"
#: Folder of the named sets.
DATA: Final = Path(__file__).parent / "data"
#: Largest set when unpacked, bytes: about two thousand lives.
_MAX_BYTES: Final = 256 * 2**20


def life_sets() -> dict[str, Path]:
    """The named sets and their files."""
    return {path.name.removesuffix(SUFFIX): path for path in sorted(DATA.glob(f"*{SUFFIX}"))}


def load_lives(name_or_path: str | Path) -> tuple[Life, ...]:
    """Load the lives of a named set or a file.

    Args:
        name_or_path: such as ``lives_mini``, or a file.

    Raises:
        EpisodeError: no such set, or a line is not a usable life.
        DataError: the file is truncated or altered.
    """
    name, sets = str(name_or_path), life_sets()
    path = sets.get(name) or Path(name_or_path)
    if not path.is_file():
        raise EpisodeError(unknown_name("set of lives, or file", name, sets))
    return _load(path.resolve(), path.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _load(path: Path, _mtime: int) -> tuple[Life, ...]:
    """The lives of a file; ``_mtime`` makes the cache notice changes."""
    return tuple(Life.from_json(data, where=where) for data, where in read_lines(path, "lives", _MAX_BYTES))


def check_suffix(path: Path) -> None:
    """Raise :class:`EpisodeError` for a file name that does not end in ``.lives.xz``."""
    check_name(path, SUFFIX)


def save_lives(lives: Sequence[Life], path: Path) -> None:
    """Write a set and update its folder's manifest; the same lives give the same bytes.

    Raises:
        EpisodeError: the file's name does not end in ``.lives.xz``.
    """
    write_lines(lives, path, SUFFIX)
