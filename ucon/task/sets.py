"""Episode sets: compressed JSON lines, one episode a line, verified against a SHA-256 manifest."""

from __future__ import annotations

import json
import lzma
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import ucon
from ucon.core.errors import DataError, EpisodeError, unknown_name
from ucon.core.files import MANIFEST, canonical_json, read_verified, write_atomic, write_manifest
from ucon.task.episode import Episode

SUFFIX = ".jsonl.xz"
_PACKAGE = Path(__file__).parent / "data"
_CLONE = Path(ucon.__file__).parents[1] / "episodes"


def episode_sets() -> dict[str, Path]:
    """Named sets that are installed: ``mini`` in the package, the others in ``episodes/`` of a clone."""
    found: dict[str, Path] = {}
    for folder in (_CLONE, _PACKAGE):
        for path in sorted(folder.glob(f"*{SUFFIX}")):
            found[path.name.removesuffix(SUFFIX)] = path
    return found


def set_path(name: str) -> Path:
    """Where a named set is kept: ``mini`` in the package, the others in ``episodes/`` of the clone."""
    return (_PACKAGE if name == "mini" else _CLONE) / f"{name}{SUFFIX}"


def load_episodes(name_or_path: str | Path) -> tuple[Episode, ...]:
    """Episodes of a named set or a file.

    Raises:
        EpisodeError: no such set, or a line is not a usable episode.
        DataError: the file is truncated or altered.
    """
    sets = episode_sets()
    path = sets.get(str(name_or_path), Path(name_or_path))
    if not path.is_file():
        raise EpisodeError(unknown_name("episode set or file", str(name_or_path), sets))
    return _load(path.resolve(), path.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _load(path: Path, _mtime: int) -> tuple[Episode, ...]:
    verified = _in_manifest(path)
    raw = read_verified(path) if verified else path.read_bytes()
    try:
        text = lzma.decompress(raw).decode()
    except (lzma.LZMAError, EOFError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: not a whole episode file ({error}); restore it or make it anew") from None
    episodes = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            data = json.loads(line)
        except ValueError as error:
            raise EpisodeError(f"{path}:{number}: not JSON ({error}); restore it or make it anew") from None
        episodes.append(Episode.from_json(data, where=f"{path}:{number}"))
    if not episodes:
        raise EpisodeError(f"{path}: no episodes in it, expected one a line")
    return tuple(episodes)


def save_episodes(episodes: Sequence[Episode], path: Path) -> None:
    """Write a set and bring its folder's manifest up to date; the same episodes give the same bytes."""
    if not path.name.endswith(SUFFIX):
        raise EpisodeError(f"{path}: expected a name ending in {SUFFIX}")
    text = "".join(canonical_json(episode.to_json()) + "\n" for episode in episodes)
    write_atomic(path, lzma.compress(text.encode(), preset=6))
    write_manifest(path.parent, [p.name for p in path.parent.glob(f"*{SUFFIX}")])


def _in_manifest(path: Path) -> bool:
    manifest = path.parent / MANIFEST
    try:
        return path.name in json.loads(manifest.read_text())["files"]
    except FileNotFoundError:
        return False
    except (ValueError, KeyError, TypeError):
        raise DataError(f"{manifest}: not a usable manifest; restore it from the release") from None
