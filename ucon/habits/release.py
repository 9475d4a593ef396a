"""The files of the official release's task folder, and the names they use for things.

The raw files under ``origin/`` were never cleaned: they name models (``coffee_table_fqluyq_0``,
``bottom_cabinet-jhymlr``) and instances (``vinegar_bottle_194``) instead of categories, write ``on_top`` for ``ontop``,
put quotes around locations, and give some tasks as texts that hold JSON.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.text import is_shown
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import JsonError, parse_json

DEFAULT_FILE: Final = "seen_obj_seen_scene.json"
#: The file that lists the categories in each scene.
STANDING_FILE: Final = "scene_obj.json"
ORIGIN: Final = "origin"
_SPLITS: Final = tuple(f"{o}_obj_{s}_scene" for o in ("seen", "unseen") for s in ("seen", "unseen"))
TASK_FILES: Final = (
    *(f"{split}{door}.json" for split in _SPLITS for door in ("", "_nodoor")),
    *("task.json", "task_merge_category.json", "task_merge_no_door.json", "task_nodoor.json"),
    *("task_with_answer.json", "task_with_multi_habit_answer.json", "test.json"),
)
INDEX_FILES: Final = frozenset(
    (
        *("id2sem.json", "obj.json", "scene_obj.json", "sem2id.json"),
        *("test_object_categories.json", "train_object_categories.json"),
    )
)
"""Files that list things, not tasks."""
_PATTERNS: Final = ("*seen_obj_*seen_scene*.json", "task*.json", "test*.json", f"{ORIGIN}/*.json")

_RELATION_NAMES: Final = {"on": "ontop", "on_top": "ontop", "on_top_of": "ontop", "next_to": "nextto", "in": "inside"}
_LOCATION: Final = re.compile(r"""['"\s]*([^.()]+)\.place_(\w+)\(([^()]+)\)['"\s]*""")
#: Largest file; the release's has some tens of megabytes.
_MAX_BYTES: Final = 256 * 2**20
_MODEL: Final = re.compile(r"[a-z0-9]{6}")


def task_files(folder: Path) -> list[Path]:
    """The task files of a release folder: its own, then those of ``origin/``, each by name."""
    found = [path for path in _json_files(folder) if _is_task_file(path.relative_to(folder).as_posix())]
    return sorted(found, key=lambda path: (path.parent != folder, path.name))


def release_warnings(folder: Path) -> list[str]:
    """One line for every task file that a folder lacks, and for every file that is not part of the release."""
    found = {path.relative_to(folder).as_posix() for path in _json_files(folder)}
    lines = [f"{folder / name}: missing, though it is part of the release" for name in TASK_FILES if name not in found]
    if not any(name.startswith(f"{ORIGIN}/") for name in found):
        lines.append(f"{folder / ORIGIN}: no *.json in it, where the release has its raw files")
    others = sorted(name for name in found - INDEX_FILES if not _is_task_file(name))
    return lines + [f"{folder / name}: not a file of the release, left out" for name in others]


def default_file(folder: Path) -> Path:
    """The file that a folder stands for.

    Raises:
        DataError: it is missing; names the task files that are there.
    """
    file = folder / DEFAULT_FILE
    if file.is_file():
        return file
    found = ", ".join(path.relative_to(folder).as_posix() for path in task_files(folder)) or "no task file at all"
    raise DataError(f"{folder}: no {DEFAULT_FILE} in it, found {found}; give the path of one file, or use --all")


def categories_in(folder: Path, scenes: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Categories in each scene, from the list that the release keeps next to its tasks.

    Args:
        folder: of the tasks.
        scenes: scenes to look up; those that the list lacks are left out.

    Returns:
        Categories by scene; empty without a list.

    Raises:
        DataError: there is a list, but it cannot be read.
    """
    path = folder / STANDING_FILE
    if not path.is_file():
        return {}
    listed, _ = load_release_file(path)
    found = {scene: listed[scene] for scene in sorted(scenes) if scene in listed}
    for scene, names in found.items():
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise DataError(f"{path}: {brief(scene)}: {kind(names)}, expected a list of categories")
    return {scene: tuple(sorted(set(names))) for scene, names in found.items()}


def load_release_file(file: Path) -> tuple[dict[str, Any], list[str]]:
    """Read a file of the release.

    Returns:
        The object in it, and the keys that an object has twice (the last one counts).

    Raises:
        DataError: the file cannot be read, or holds no JSON object.
    """
    try:
        raw = read_bounded(file, _MAX_BYTES)
    except OSError as error:
        raise DataError(f"{file}: cannot be read ({error.strerror}); expected a task file of the release") from None
    twice: list[str] = []
    try:
        content = parse_json(raw, max_bytes=_MAX_BYTES, twice=twice, surrogates=True)
    except JsonError as error:
        raise DataError(f"{file}{error.at}: {error}; the file is cut off or altered, download it again") from None
    if not isinstance(content, dict) or not content:
        raise DataError(f"{file}: {kind(content)} at the top, expected an object whose keys are scenes")
    return content, twice


def unpacked(task: Any) -> Any:
    """A task that is given as a text of JSON, parsed; anything else as it is."""
    if not isinstance(task, str):
        return task
    try:
        return parse_json(task, surrogates=True)
    except JsonError:
        return task


def kind(value: Any) -> str:
    """The kind of a JSON value, for messages."""
    return {dict: "object", list: "list", str: "text", type(None): "null"}.get(type(value), type(value).__name__)


def plain(text: Any) -> str | None:
    """A text on one line, without characters that cannot be displayed; None for anything else."""
    if not isinstance(text, str):
        return None
    line = text if is_shown(text) else " ".join(text.split())
    return line if line.strip() and is_shown(line) else None


def category_name(text: str, categories: Collection[str] | None) -> str:
    """The category of a name: ``sink`` of ``sink_ksecxq_0``, ``carving_knife`` of ``Carving knife``.

    Args:
        text: name of a category, a model or an instance.
        categories: names that exist, or None.

    Returns:
        The longest form that is among ``categories``; the whole name where none is.
    """
    name = re.sub(r"[\s-]+", "_", text.strip("'\" \t\n").lower())
    if categories is None or name in categories:
        return name
    for form in _shorter(name):
        if form in categories:
            return form
    return name


def location_parts(text: str, categories: Collection[str] | None) -> tuple[str, str, str] | None:
    """Target, relation and anchor of ``target.place_relation(anchor)``.

    Names are mapped by :func:`category_name`.

    Returns:
        None where the text is no location.
    """
    match = _LOCATION.fullmatch(text)
    if match is None:
        return None
    relation = match[2].lower()
    target, anchor = category_name(match[1], categories), category_name(match[3], categories)
    return target, _RELATION_NAMES.get(relation, relation), anchor


def _shorter(name: str) -> Iterator[str]:
    """A name without its instance number, then without its model."""
    parts = name.split("_")
    if len(parts) > 1 and parts[-1].isdecimal():
        parts.pop()
        yield "_".join(parts)
    if len(parts) > 1 and _MODEL.fullmatch(parts[-1]):
        yield "_".join(parts[:-1])


def _json_files(folder: Path) -> list[Path]:
    return [path for pattern in ("*.json", f"{ORIGIN}/*.json") for path in folder.glob(pattern) if path.is_file()]


def _is_task_file(name: str) -> bool:
    return name not in INDEX_FILES and any(fnmatch(name, pattern) for pattern in _PATTERNS)
