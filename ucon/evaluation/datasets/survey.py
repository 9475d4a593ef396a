"""A survey among people: rating sheets of habits and places, a separate key, and readers for both.

Every item shows a habit that supports a placement of its entry, and a place. In half of the items it is that place; in
the others it is swapped for a place where another household keeps the same category, and this household never does. So
no swapped place is absurd, and only the sentence tells the two apart. Contexts are not shown, and each category appears
once.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.rng import stream
from ucon.core.untrusted.plain_file import read_bounded
from ucon.habits import Entry, HabitDataset, Placement

QUESTIONS: Final = (
    "Is this a habit a real person could have? (1 = surely not ... 5 = surely)",
    "Would you look for the OBJECT at PLACE after reading it? (yes / no / unsure)",
)
SHEET_FIELDS: Final = ("item", "object", "habit", "place", "real_1_to_5", "look_yes_no_unsure")
LOOK: Final = ("yes", "unsure", "no")
#: Largest sheet or key that is read, bytes.
_MAX_BYTES: Final = 16 * 2**20
_WORDS: Final = {"ontop": "on top of", "inside": "inside", "under": "under", "nextto": "next to"}


@dataclass(frozen=True, slots=True)
class RatedHabit:
    """One item of a survey with its key; sheets show only the first four fields."""

    item: int
    object: str
    habit: str
    place: str
    truth: str
    """``true`` or ``swapped``: whether the habit supports the place."""
    entry: str
    relation: str
    anchor: str


@dataclass(frozen=True, slots=True)
class Rating:
    """One rater's answers about one item; None where left empty."""

    item: int
    rater: str
    real: int | None
    look: str | None


def draw_items(dataset: HabitDataset, n: int, seed: int = 0) -> list[RatedHabit]:
    """Draw the items of a survey: half (rounded up) with true placements, half with swapped ones, in random order.

    Args:
        dataset: habits with labels.
        n: number of items, each of a different category.
        seed: of the draw.

    Raises:
        ConfigError: the dataset has no labels, or fewer usable categories.
    """
    if not dataset.labelled:
        raise ConfigError(
            f"dataset '{dataset.name}' does not say which habit supports which place; a survey needs that"
        )
    pool: list[tuple[Entry, str, Placement, Placement]] = []
    for category in dataset.categories:
        rng = stream(seed, "survey", category)
        if (one := _candidate(dataset.entries_of(category), rng)) is not None:
            pool.append(one)
    if len(pool) < 2:
        raise ConfigError(
            f"dataset '{dataset.name}' is too small for a survey: {len(pool)} of its categories can be used, "
            "expected at least 2 that households keep in different places; give a larger one"
        )
    if not 2 <= n <= len(pool):
        raise ConfigError(f"--n {n}: expected 2 to {len(pool)} items, one per category of '{dataset.name}'")
    order = stream(seed, "survey", "draw").permutation(len(pool))[:n]
    swapped = set(stream(seed, "survey", "swap").permutation(n)[: n // 2].tolist())
    items = []
    for number, index in enumerate(order):
        entry, text, own, other = pool[index]
        place = other if number in swapped else own
        where = f"{_WORDS[place.relation]} the {place.anchor.replace('_', ' ')}"
        truth = "swapped" if number in swapped else "true"
        thing = entry.category.replace("_", " ")
        items.append(RatedHabit(number + 1, thing, text, where, truth, entry.id, place.relation, place.anchor))
    return items


def _candidate(entries: Sequence[Entry], rng: np.random.Generator) -> tuple[Entry, str, Placement, Placement] | None:
    """An entry of a category, one of its habits, a place that it supports and another household's.

    None where there is none.
    """
    for i in rng.permutation(len(entries)):
        entry = entries[i]
        own = {place.anchor for place in entry.placements}
        others = [p for e in entries if e.kind == entry.kind for p in e.placements if p.anchor not in own]
        habits = [habit for habit in entry.habits if habit.supports]
        if others and habits:
            habit = habits[int(rng.integers(len(habits)))]
            place = entry.placements[habit.supports[int(rng.integers(len(habit.supports)))]]
            return entry, habit.text, place, others[int(rng.integers(len(others)))]
    return None


def sheet_csv(items: Sequence[RatedHabit], answers: Mapping[int, Rating] = MappingProxyType({})) -> str:
    """The sheet that raters fill in, as CSV.

    Args:
        items: of the survey.
        answers: answers that are filled in already, by item.
    """
    said = {number: ("" if one.real is None else one.real, one.look or "") for number, one in answers.items()}
    rows = [(one.item, one.object, one.habit, one.place, *said.get(one.item, ("", ""))) for one in items]
    return _csv(SHEET_FIELDS, rows)


def key_csv(items: Sequence[RatedHabit]) -> str:
    """The key for scoring, as CSV; raters must not see it."""
    return _csv(tuple(field.name for field in fields(RatedHabit)), [astuple(one) for one in items])


def read_key(path: Path) -> dict[int, RatedHabit]:
    """Read a key.

    Args:
        path: CSV file.

    Returns:
        Items by number.

    Raises:
        DataError: naming file and line of a damaged row.
    """
    found: dict[int, RatedHabit] = {}
    for line, row in _rows(path, tuple(field.name for field in fields(RatedHabit)), "the key of `habits survey make`"):
        number = _number(path, line, row["item"])
        if row["truth"] not in ("true", "swapped"):
            raise DataError(f"{path}:{line}: truth '{brief(row['truth'])}', expected true or swapped; restore the key")
        if number in found:
            raise DataError(f"{path}:{line}: item {number} is listed twice; restore the key")
        found[number] = RatedHabit(number, *(row[field.name] for field in fields(RatedHabit)[1:]))
    return found


def read_sheet(path: Path, key: dict[int, RatedHabit]) -> list[Rating]:
    """Read the answers of one rater, who is named after the file.

    Args:
        path: CSV file.
        key: items by number.

    Raises:
        DataError: naming file and line of an invalid answer, a wrong or missing item, or text of another survey.
    """
    answers: dict[int, Rating] = {}
    for line, row in _rows(path, SHEET_FIELDS, "a sheet of `habits survey make`"):
        where, number = f"{path}:{line}", _number(path, line, row["item"])
        if number not in key:
            raise DataError(f"{where}: item {number} is not in the key; is this the sheet of another survey?")
        if number in answers:
            raise DataError(f"{where}: item {number} is answered twice; keep one line")
        if (row["habit"], row["place"]) != (key[number].habit, key[number].place):
            raise DataError(
                f"{where}: the text of item {number} differs from the key's; is this another survey's sheet?"
            )
        real, look = row["real_1_to_5"], row["look_yes_no_unsure"].lower()
        if real not in ("", "1", "2", "3", "4", "5"):
            raise DataError(f"{where}: real_1_to_5 is '{brief(real)}', expected a whole number from 1 to 5, or nothing")
        if look not in ("", *LOOK):
            raise DataError(f"{where}: look_yes_no_unsure is '{brief(look)}', expected yes, no, unsure, or nothing")
        answers[number] = Rating(number, path.stem, int(real) if real else None, look or None)
    if missing := sorted(set(key) - set(answers)):
        raise DataError(
            f"{path}: item {missing[0]} is missing ({len(missing)} in all); leave lines in, answers may be empty"
        )
    if not any(answer.real or answer.look for answer in answers.values()):
        raise DataError(f"{path}: no answer at all; omit empty sheets")
    return list(answers.values())


def _number(path: Path, line: int, text: str) -> int:
    if not text.isdecimal() or len(text) > 9:  # int() raises on thousands of digits
        raise DataError(f"{path}:{line}: item '{brief(text)}', expected the item's number")
    return int(text)


def _csv(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return buffer.getvalue()


def _rows(path: Path, head: Sequence[str], what: str) -> list[tuple[int, dict[str, str]]]:
    """Rows of a CSV file with their line numbers; separated by commas, or by semicolons as some spreadsheets write."""
    try:
        raw = read_bounded(path, _MAX_BYTES)
        if len(raw) > _MAX_BYTES:
            raise DataError(f"{path}: more than {_MAX_BYTES:,} bytes; expected {what}")
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DataError(f"{path}:{line}: not UTF-8; save it as 'CSV UTF-8'") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); expected {what}") from None
    delimiter = ";" if text.startswith(f"{head[0]};") else ","
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    rows: list[tuple[int, dict[str, str]]] = []
    try:
        if (first := next(reader, [])) != list(head):
            raise DataError(f"{path}:1: columns '{brief(', '.join(first))}', expected {', '.join(head)} ({what})")
        for row in reader:
            if not any(row):
                continue
            if len(row) != len(head):
                raise DataError(f"{path}:{reader.line_num}: {len(row)} columns, expected {len(head)}")
            rows.append((reader.line_num, {name: cell.strip() for name, cell in zip(head, row, strict=True)}))
    except csv.Error as error:
        raise DataError(f"{path}:{reader.line_num}: not CSV ({error}); expected {what}") from None
    if not rows:
        raise DataError(f"{path}:1: no item; expected {what}")
    return rows
