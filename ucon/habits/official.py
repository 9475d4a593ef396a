"""Reader of the official release's task files, from a path that the user gives; their text is never shipped.

Two forms are accepted: scene -> category -> list of tasks, and scene -> list of tasks. A task has the fields
``user_instruction``, ``basic_object_name``, ``prompt``, ``habits`` and ``location`` (or ``locations``). A location
reads ``target.place_relation(anchor)``. Other fields, such as answers of language models, are ignored. Whatever does
not fit is reported with its file and position.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, cast

from ucon.core.errors import DataError, brief
from ucon.habits.release import (
    categories_in,
    category_name,
    default_file,
    kind,
    load_release_file,
    location_parts,
    plain,
    unpacked,
)
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.objects.model import RELATIONS, Relation

MAX_TEXT: Final = 2000
"""Characters of one sentence; the release's longest has 259."""
#: Most reasons that :meth:`ImportReport.left_out` lists.
_REASONS: Final = 3


@dataclass(frozen=True, slots=True)
class ReleaseProblem:
    """One fault of a file; ``where`` is the file and the path inside it."""

    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message}"


@dataclass(frozen=True, slots=True)
class Located:
    """A placement that was read, and its position in the file."""

    where: str
    scene: str
    category: str
    placement: Placement


@dataclass
class ImportReport:
    """Counts and faults of a file.

    Attributes:
        path: the file.
        scenes: scenes with tasks.
        categories: target categories with usable tasks.
        tasks: tasks listed.
        habits: sentences listed.
        locations: locations listed.
        problems: all faults.
        located: every placement of the dataset, in the order of the file.
    """

    path: Path
    scenes: int = 0
    categories: int = 0
    tasks: int = 0
    habits: int = 0
    locations: int = 0
    problems: list[ReleaseProblem] = field(default_factory=list)
    located: list[Located] = field(default_factory=list)

    def left_out(self, habits: int) -> str | None:
        """One line on what of the file is missing from the dataset, and why.

        Args:
            habits: sentences of the dataset.

        Returns:
            None if nothing is missing.
        """
        lost = {"habits": (self.habits - habits, self.habits)}
        lost["locations"] = (self.locations - len(self.located), self.locations)
        if not any(count for count, _ in lost.values()):
            return None
        counts = " and ".join(f"{count} of {total} {name}" for name, (count, total) in lost.items() if count)
        kinds = Counter(re.sub(r"'.*?'|\d[\d,]*", "...", problem.message) for problem in self.problems)
        why = "; ".join(f"{count} x {kind}" for kind, count in kinds.most_common(_REASONS))
        more = f"; and {len(kinds) - _REASONS} other reasons" if len(kinds) > _REASONS else ""
        return f"{self.path}: {counts} left out ({why}{more}); `python -m ucon habits import` lists each"

    def add(self, where: str, message: str) -> None:
        """Add a fault."""
        self.problems.append(ReleaseProblem(where, message))


def official(path: Path | str, categories: Collection[str] | None = None) -> tuple[HabitDataset, ImportReport]:
    """Read one file of the release.

    Args:
        path: file, or a folder, which means its ``seen_obj_seen_scene.json``.
        categories: names that exist; targets and anchors outside are reported and left out. Names of models and
            instances are mapped to their category. None accepts any name as it is.

    Returns:
        The dataset and the report.

    Raises:
        DataError: the file cannot be read, is not JSON of one of the two forms, or holds no usable task.
    """
    file = Path(path)
    file = default_file(file) if file.is_dir() else file
    content, twice = load_release_file(file)
    report = ImportReport(file)
    for name in twice:
        report.add(str(file), f"key '{brief(name)}' appears twice in one object; only the last one is read")
    entries: list[Entry] = []
    number: dict[tuple[str, str], int] = {}
    scenes: set[str] = set()
    for scene, category, where, task in _tasks(file, content, report):
        scenes.add(scene)
        entry = _entry(scene, category, where, task, report, categories)
        if entry is None:
            continue
        index = number.get((scene, entry.category), 0)
        number[scene, entry.category] = index + 1
        entries.append(replace(entry, id=f"{scene}/{entry.category}/{index}"))
    report.scenes, report.categories = len(scenes), len({entry.category for entry in entries})
    if not entries:
        raise DataError(f"{file}: no usable task; expected scene -> category -> tasks (or scene -> tasks)")
    standing = categories_in(file.parent, scenes)
    return HabitDataset(f"official:{file.stem}", tuple(entries), labelled=False, standing=standing), report


def _tasks(
    file: Path, content: dict[str, Any], report: ImportReport
) -> Iterator[tuple[str, str | None, str, dict[str, Any]]]:
    """(scene, category or None in list form, where, task) of everything that is an object."""
    for scene, group in content.items():
        if plain(scene) != scene:
            report.add(str(file), f"scene '{brief(scene)}', expected a name")
            continue
        if isinstance(group, dict):
            lists = [(name, f"{file}: {brief(scene)} > {brief(name)}", tasks) for name, tasks in group.items()]
        else:
            lists = [(None, f"{file}: {brief(scene)}", group)]
        for category, where, tasks in lists:
            if not isinstance(tasks, list):
                report.add(where, f"{kind(tasks)}, expected a list of tasks")
                continue
            for i, task in enumerate(map(unpacked, tasks)):
                if isinstance(task, dict):
                    yield scene, category, f"{where}[{i}]", task
                else:
                    report.add(f"{where}[{i}]", f"{kind(task)}, expected an object with habits and location")


def _entry(
    scene: str,
    category: str | None,
    where: str,
    task: dict[str, Any],
    report: ImportReport,
    categories: Collection[str] | None,
) -> Entry | None:
    report.tasks += 1
    places = "location" if "location" in task else "locations"
    report.habits += _listed(task.get("habits"))
    report.locations += _listed(task.get(places))
    habits = [Habit(text) for text in _strings(task, "habits", where, report).values()]
    locations = _strings(task, places, where, report)
    target = _target(task.get("basic_object_name"), category, list(locations.values()), where, report, categories)
    if target is None:
        return None
    placements = _placements(target, locations, report, categories)
    if not placements or not habits:
        report.add(where, f"{len(placements)} usable locations and {len(habits)} habits, expected at least 1 of each")
        return None
    told = task.get("user_instruction")
    household = plain(told)
    if told and household is None:
        report.add(where, f"user_instruction: {_fault(told)}, expected a text; left out")
    report.located += [Located(at, scene, target, placement) for at, placement in placements.items()]
    return Entry("", target, household or "", tuple(placements.values()), tuple(habits), scene)


def _target(
    told: Any,
    category: str | None,
    locations: list[str],
    where: str,
    report: ImportReport,
    categories: Collection[str] | None,
) -> str | None:
    """The target's category; where a raw file uses a free name, the one that all its locations use replaces it."""
    if plain(told) is None:
        report.add(where, f"basic_object_name is {_fault(told)}, expected the target's category")
        return None
    target = category_name(told, categories)
    if category is not None and target != category_name(category, categories):
        report.add(where, f"basic_object_name '{brief(target)}' is listed under '{brief(category)}'")
    if categories is None or target in categories:
        return target
    named = {parts[0] for text in locations if (parts := location_parts(text, categories))}
    if category is None and len(named) == 1 and named <= set(categories):
        report.add(
            where, f"basic_object_name '{brief(told)}' is no category; read as '{min(named)}', from its locations"
        )
        return min(named)
    report.add(where, f"unknown target category '{brief(target)}'")
    return None


def _listed(value: Any) -> int:
    return len(value) if isinstance(value, list) else 0


def _strings(task: dict[str, Any], key: str, where: str, report: ImportReport) -> dict[str, str]:
    """The usable texts of a list by their position in the file."""
    value = task.get(key)
    if not isinstance(value, list):
        report.add(where, f"{key} is {kind(value)}, expected a list of texts")
        return {}
    found: dict[str, str] = {}
    for i, text in enumerate(value):
        at, line = f"{where}.{key}[{i}]", plain(text)
        if line is None:
            report.add(at, f"{_fault(text)}, expected a text")
        elif len(line) > MAX_TEXT:
            report.add(at, f"{len(line)} characters, expected at most {MAX_TEXT}")
        else:
            found[at] = line
    return found


def _placements(
    target: str, locations: dict[str, str], report: ImportReport, categories: Collection[str] | None
) -> dict[str, Placement]:
    """The usable placements by their position in the file."""
    found: dict[str, Placement] = {}
    for at, text in locations.items():
        parts = location_parts(text, categories)
        fault = _placement_fault(target, text, parts, list(found.values()), categories)
        if fault or parts is None:
            report.add(at, fault)
        else:
            found[at] = Placement(cast(Relation, parts[1]), parts[2])
    return found


def _placement_fault(
    target: str,
    text: str,
    parts: tuple[str, str, str] | None,
    earlier: list[Placement],
    categories: Collection[str] | None,
) -> str:
    """What is wrong with a location; empty where nothing is."""
    if parts is None or (categories is None and not re.fullmatch(r"\w+", parts[2])):
        return f"'{brief(text)}', expected target.place_relation(anchor)"
    named, relation, anchor = parts
    if relation not in RELATIONS:
        return f"unknown relation '{relation}', expected {', '.join(RELATIONS)}"
    if named != target:
        return f"location of '{named}' in a task about '{target}'"
    if anchor == target:
        return f"'{target}' placed {relation} itself"
    if categories is not None and anchor not in categories:
        return f"unknown anchor category '{anchor}'"
    if any((p.relation, p.anchor) == (relation, anchor) for p in earlier):
        return f"'{relation} {anchor}' is listed twice"
    return ""


def _fault(value: Any) -> str:
    """Describes a value that should be a text, for messages."""
    if not isinstance(value, str):
        return kind(value)
    return f"'{brief(value)}' with a character that cannot be shown" if value.strip() else "empty"
