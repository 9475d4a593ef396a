"""Episode sets: compressed JSON lines, one episode per line, verified against a SHA-256 manifest.

A named set has one file for each rule set, since a shortest path is valid only under the rules it was found with:
``mini`` is the version for the paper's rules, ``mini.released_code`` for the released environment's and
``mini.real_robot`` for the robot's; the episodes of ``mini.context`` state their context.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import ucon
from ucon.core.errors import EpisodeError, unknown_name
from ucon.core.files import user_pack, write_atomic, write_manifest
from ucon.task.episode import Episode
from ucon.task.packed_lines import check_name, read_lines, write_lines
from ucon.task.rules import PAPER, RULES, task_rules

SUFFIX = ".jsonl.xz"
CONTEXT = "context"
#: Name ending of sets whose episodes all state a context; these sets have no version without it.
STATING = "_context"
#: Folder of episode sets in a pack, see :func:`pack_sets`.
IN_PACK = "episodes"
#: Largest set when unpacked, bytes: about thirty thousand episodes.
_MAX_BYTES = 256 * 2**20
_PACKAGE = Path(__file__).parent / "data"
_CLONE = Path(ucon.__file__).parents[1] / "episodes"


def set_name(name: str, task: str = PAPER.name, *, context: bool = False) -> str:
    """Full name of a version of a set: ``mini``, ``mini.released_code``, ``mini.context``.

    Args:
        name: of the set.
        task: rule set under which it was made.
        context: whether the version's episodes state their context.
    """
    rules = task_rules(task)
    suffix = f".{CONTEXT}" if context and not name.endswith(STATING) else ""
    return name + (f".{rules.name}" if rules != PAPER else "") + suffix


def episode_sets() -> dict[str, Path]:
    """The named sets on this machine and their files.

    ``mini`` is in the package; the others are in ``episodes/`` of a clone or in a pack.

    Raises:
        ConfigError: ``UCON_PACK`` names no folder.
    """
    found: dict[str, Path] = {}
    pack = user_pack()
    for folder in (*(() if pack is None else (pack / IN_PACK,)), _CLONE, _PACKAGE):
        for path in sorted(folder.glob(f"*{SUFFIX}")):
            found[path.name.removesuffix(SUFFIX)] = path
    return found


def set_path(name: str) -> Path:
    """Where a named set is stored: ``mini`` in the package, the others in ``episodes/`` of the clone."""
    return (_PACKAGE if name.split(".")[0] == "mini" else _CLONE) / f"{name}{SUFFIX}"


def load_episodes(name_or_path: str | Path, task: str = PAPER.name, *, context: bool = False) -> tuple[Episode, ...]:
    """Load the episodes of a named set or a file.

    Args:
        name_or_path: ``mini``, ``val``, ``test``, or a file.
        task: rule set; for a named set, the version made under it is loaded.
        context: load the version whose episodes state their context.

    Raises:
        EpisodeError: no such set, no version for these rules, or a line is not a usable episode.
        DataError: the file is truncated or altered.
    """
    name, sets = str(name_or_path), episode_sets()
    wanted = set_name(name, task, context=context)
    if wanted not in sets and name in _base_names(sets):
        how = f"task={task}" + (" task.context=true" if context else "")
        options = f"--task {task}" + (" --context" if context else "")
        raise EpisodeError(
            f"episode set '{name}': not made under {how} yet; make it (python -m ucon episodes make {name} "
            f"{options}), or choose {' or '.join(_made_under(wanted, name, sets)) or 'another task'}, "
            "or a file by its path"
        )
    path = sets.get(wanted) or sets.get(name) or Path(name_or_path)
    if not path.is_file():
        raise EpisodeError(unknown_name("episode set or file", name, sets))
    return _load(path.resolve(), path.stat().st_mtime_ns)


def _base_names(sets: Iterable[str]) -> set[str]:
    """Names of sets without their versions: ``episodes=`` and ``task=`` are separate options."""
    versions = {*RULES, CONTEXT}
    return {name.split(".")[0] for name in sets if versions.issuperset(name.split(".")[1:])}


def _made_under(wanted: str, name: str, sets: Iterable[str]) -> list[str]:
    """Values of ``episodes=`` for which the version of ``wanted`` exists."""
    names, version = set(sets), wanted.removeprefix(name)
    return [f"episodes={base}" for base in sorted(_base_names(names)) if f"{base}{version}" in names]


@lru_cache(maxsize=8)
def _load(path: Path, _mtime: int) -> tuple[Episode, ...]:
    """The episodes of a file; ``_mtime`` makes the cache notice changes."""
    return tuple(Episode.from_json(data, where=where) for data, where in read_lines(path, "episodes", _MAX_BYTES))


def check_suffix(path: Path) -> None:
    """Raise :class:`EpisodeError` for a file name that does not end in ``.jsonl.xz``."""
    check_name(path, SUFFIX)


def save_episodes(episodes: Sequence[Episode], path: Path) -> None:
    """Write a set and update its folder's manifest; the same episodes give the same bytes.

    Raises:
        EpisodeError: the file's name does not end in ``.jsonl.xz``.
    """
    write_lines(episodes, path, SUFFIX)


def pack_sets(names: Iterable[str], folder: Path) -> list[Path]:
    """Copy sets into a folder, with a manifest.

    Args:
        names: named sets (all their versions are copied) or files.
        folder: destination.

    Returns:
        The copied files.
    """
    sets, paths = episode_sets(), []
    for name in names:
        versions = [path for known, path in sets.items() if known == name or known.startswith(f"{name}.")]
        for source in versions or [Path(name)]:
            load_episodes(source)
            path = folder / source.name
            write_atomic(path, source.read_bytes())
            paths.append(path)
    write_manifest(folder, [path.name for path in folder.glob(f"*{SUFFIX}")])
    return paths
