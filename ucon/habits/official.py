"""Reader of the official release's task files. Its text is read from a path the user gives and never shipped.

Two forms are accepted: scene -> category -> list of tasks, and scene -> list of tasks. A task has the fields
``user_instruction``, ``basic_object_name``, ``prompt``, ``habits`` and ``location``; a location reads
``target.place_relation(anchor)``. Whatever does not fit is reported with its file and position.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from ucon.core.errors import DataError
from ucon.habits.types import RELATIONS, Entry, Habit, HabitDataset, Placement, Relation

DEFAULT_FILE = "seen_obj_seen_scene.json"
_LOCATION = re.compile(r"\s*(\w+)\.place_(\w+)\((\w+)\)\s*")


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that does not fit. ``where`` is the file and the path inside it."""

    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message}"


@dataclass(frozen=True, slots=True)
class Located:
    """A placement of an entry that was read, and where it stands in the file."""

    where: str
    scene: str
    category: str
    placement: Placement


@dataclass
class ImportReport:
    """What a file holds, counted before anything is left out, and everything that does not fit."""

    path: Path
    scenes: int = 0
    categories: int = 0
    tasks: int = 0
    habits: int = 0
    locations: int = 0
    problems: list[Problem] = field(default_factory=list)
    located: list[Located] = field(default_factory=list)
    """Every placement of the dataset, in the order of the file."""

    def add(self, where: str, message: str) -> None:
        """Report one malformed thing."""
        self.problems.append(Problem(where, message))


def official(path: Path | str, categories: Collection[str] | None = None) -> tuple[HabitDataset, ImportReport]:
    """Dataset of one file of the release (a folder means its ``seen_obj_seen_scene.json``).

    Args:
        path: file or folder.
        categories: names that exist; targets and anchors outside are reported and left out. None accepts any.

    Raises:
        DataError: the file cannot be read, is not JSON of one of the two forms, or holds no usable task.
    """
    file = Path(path)
    file = file / DEFAULT_FILE if file.is_dir() else file
    content = _load(file)
    report = ImportReport(file)
    entries: list[Entry] = []
    number: dict[tuple[str, str], int] = {}
    names: set[str] = set()
    scenes: set[str] = set()
    for scene, category, where, task in _tasks(file, content, report):
        scenes.add(scene)
        entry = _entry(scene, category, where, task, report, categories)
        if entry is None:
            continue
        names.add(entry.category)
        index = number.get((scene, entry.category), 0)
        number[scene, entry.category] = index + 1
        entries.append(
            Entry(f"{scene}/{entry.category}/{index}", *_rest(entry), scene=scene),
        )
    report.scenes, report.categories = len(scenes), len(names)
    if not entries:
        raise DataError(f"{file}: no usable task; expected scene -> category -> tasks (or scene -> tasks)")
    return HabitDataset(f"official:{file.stem}", tuple(entries), labelled=False), report


def _rest(entry: Entry) -> tuple[str, str, tuple[Placement, ...], tuple[Habit, ...]]:
    return entry.category, entry.household, entry.placements, entry.habits


def _load(file: Path) -> dict[str, Any]:
    try:
        raw = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: cannot be read ({error.strerror}); expected a task file of the release") from None
    try:
        content = json.loads(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise DataError(f"{file}:{line}: not UTF-8 ({error.reason}); download the file again") from None
    except json.JSONDecodeError as error:
        raise DataError(
            f"{file}:{error.lineno}:{error.colno}: not JSON ({error.msg}); the file is cut off or altered, "
            "download it again"
        ) from None
    except RecursionError:
        raise DataError(f"{file}: nested too deeply; expected scene -> category -> list of tasks") from None
    if not isinstance(content, dict) or not content:
        raise DataError(f"{file}: {_kind(content)} at the top, expected an object whose keys are scenes")
    return content


def _kind(value: Any) -> str:
    return {dict: "object", list: "list", str: "text", type(None): "null"}.get(type(value), type(value).__name__)


def _tasks(
    file: Path, content: dict[str, Any], report: ImportReport
) -> Iterator[tuple[str, str | None, str, dict[str, Any]]]:
    """(scene, category or None in list form, where, task) of everything that is an object."""
    for scene, group in content.items():
        if isinstance(group, dict):
            lists = [(category, f"{file}: {scene} > {category}", tasks) for category, tasks in group.items()]
        else:
            lists = [(None, f"{file}: {scene}", group)]
        for category, where, tasks in lists:
            if not isinstance(tasks, list):
                report.add(where, f"{_kind(tasks)}, expected a list of tasks")
                continue
            for i, task in enumerate(tasks):
                if isinstance(task, dict):
                    yield scene, category, f"{where}[{i}]", task
                else:
                    report.add(f"{where}[{i}]", f"{_kind(task)}, expected an object with habits and location")


def _entry(
    scene: str,
    category: str | None,
    where: str,
    task: dict[str, Any],
    report: ImportReport,
    categories: Collection[str] | None,
) -> Entry | None:
    report.tasks += 1
    target = task.get("basic_object_name")
    habits = [Habit(text) for text in _strings(task, "habits", where, report)]
    locations = _strings(task, "location", where, report)
    report.habits += len(habits)
    report.locations += len(locations)
    if not isinstance(target, str) or not target:
        report.add(where, f"basic_object_name is {_kind(target)}, expected the target's category")
        return None
    if category is not None and target != category:
        report.add(where, f"basic_object_name '{target}' is listed under '{category}'")
    if categories is not None and target not in categories:
        report.add(where, f"unknown target category '{target}'")
        return None
    placements = _placements(target, locations, where, report, categories)
    if not placements or not habits:
        report.add(where, f"{len(placements)} usable locations and {len(habits)} habits, expected at least 1 of each")
        return None
    household = str(task.get("user_instruction") or "")
    report.located += [Located(at, scene, target, placement) for at, placement in placements.items()]
    return Entry("", target, household, tuple(placements.values()), tuple(habits), scene)


def _strings(task: dict[str, Any], key: str, where: str, report: ImportReport) -> list[str]:
    value = task.get(key)
    if not isinstance(value, list):
        report.add(where, f"{key} is {_kind(value)}, expected a list of texts")
        return []
    for i, text in enumerate(value):
        if not isinstance(text, str) or not text.strip():
            report.add(f"{where}.{key}[{i}]", f"{_kind(text) if text else 'empty'}, expected a text")
    return [text for text in value if isinstance(text, str) and text.strip()]


def _placements(
    target: str, locations: list[str], where: str, report: ImportReport, categories: Collection[str] | None
) -> dict[str, Placement]:
    """The usable placements by their position in the file."""
    found: dict[str, Placement] = {}
    known: set[tuple[str, str]] = set()
    for i, text in enumerate(locations):
        message = ""
        match = _LOCATION.fullmatch(text)
        if match is None:
            message = f"'{text[:60]}', expected target.place_relation(anchor)"
        elif match[2] not in RELATIONS:
            message = f"unknown relation '{match[2]}', expected {', '.join(RELATIONS)}"
        elif match[1] != target:
            message = f"location of '{match[1]}' in a task about '{target}'"
        elif match[3] == target:
            message = f"'{target}' placed {match[2]} itself"
        elif categories is not None and match[3] not in categories:
            message = f"unknown anchor category '{match[3]}'"
        elif (match[2], match[3]) in known:
            message = f"'{match[2]} {match[3]}' is listed twice"
        if message or match is None:
            report.add(f"{where}.location[{i}]", message)
            continue
        known.add((match[2], match[3]))
        found[f"{where}.location[{i}]"] = Placement(cast(Relation, match[2]), match[3])
    return found
