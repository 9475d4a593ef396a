"""Sets of lives: compressed JSON lines, one life a line, verified against a SHA-256 manifest."""

from __future__ import annotations

import lzma
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

from ucon.core.errors import DataError, EpisodeError, unknown_name
from ucon.core.files import canonical_json, listed_files, read_verified, write_atomic, write_manifest
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.core.untrusted.unpack import UnpackError, unpack_xz
from ucon.lives.life import Life

SUFFIX: Final = ".lives.xz"
#: Folder of the named sets.
DATA: Final = Path(__file__).parent / "data"
#: Largest set when unpacked, bytes: some two thousand lives.
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
    try:
        raw = read_verified(path) if _in_manifest(path) else read_bounded(path, _MAX_BYTES)
        text = unpack_xz(raw, _MAX_BYTES).decode("utf-8-sig")
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); restore it or make it anew") from None
    except (UnpackError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: not a whole file of lives ({error}); restore it or make it anew") from None
    lives = []
    for number, line in enumerate(text.removesuffix("\n").split("\n") if text else (), 1):
        try:
            data = parse_json(line)
        except JsonError as error:
            raise EpisodeError(f"{path}:{number}: {error}; restore it or make it anew") from None
        lives.append(Life.from_json(data, where=f"{path}:{number}"))
    if not lives:
        raise EpisodeError(f"{path}: no lives in it, expected one a line")
    return tuple(lives)


def check_suffix(path: Path) -> None:
    """Raise :class:`EpisodeError` for a file name that does not end in ``.lives.xz``."""
    if not path.name.endswith(SUFFIX):
        raise EpisodeError(f"{path}: expected a name ending in {SUFFIX}")


def save_lives(lives: Sequence[Life], path: Path) -> None:
    """Write a set and update its folder's manifest; the same lives give the same bytes.

    Raises:
        EpisodeError: the file's name does not end in ``.lives.xz``.
    """
    check_suffix(path)
    text = "".join(canonical_json(life.to_json()) + "\n" for life in lives)
    write_atomic(path, lzma.compress(text.encode(), preset=6))
    write_manifest(path.parent, [p.name for p in path.parent.glob(f"*{SUFFIX}")])


def _in_manifest(path: Path) -> bool:
    """Whether the file's folder has a manifest that lists it."""
    try:
        return path.name in listed_files(path.parent)
    except FileNotFoundError:
        return False
