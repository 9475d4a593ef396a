r"""The habit book and its format: households described sentence by sentence in plain text files.

    # watering_can | retired schoolteacher living alone     category | household (| ... {office}: lives in offices)
    @ nextto pot_plant                                      placement 1: relation anchor
    @ ontop bench {summer}                                  placement 2, only in that context
    1: After the morning radio news, ...                    a habit that supports placement 1 (`1,2:` both)
    -: Crosswords come out once the dishes are dry.         a habit that supports none

A `#` line starts an entry; blank lines have no meaning. ``anchors.txt`` lists the anchors with the relations they
allow. A file must end with a line break; one that does not was cut off.
"""

from __future__ import annotations

import copyreg
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Final, cast

from ucon.core.errors import DataError, unknown_name
from ucon.core.files import read_verified
from ucon.core.sharing import is_the_one
from ucon.core.untrusted.plain_file import read_bounded
from ucon.habits.datafile import load_dataset_file
from ucon.habits.rules import (
    BOOK_LIMITS,
    OWN_LIMITS,
    Anchors,
    Limits,
    count_fault,
    habit_fault,
    header_fault,
    line_fault,
    placement_fault,
)
from ucon.habits.splits import category_split
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.habits.verdicts import Verdicts
from ucon.objects.model import RELATIONS, Relation

BOOK_FOLDER: Final = Path(__file__).parent / "book"
BOOK_FILE: Final = Path(__file__).parent / "data" / "book.habits.xz"
"""The book as ``python -m ucon habits build`` makes it from the text: entries with PyBullet's verdicts."""
CONTEXTS_FOLDER: Final = Path(__file__).parent / "book_contexts"
"""Text of the book's second part, whose placements differ by context."""
CONTEXTS_FILE: Final = Path(__file__).parent / "data" / "contexts.habits.xz"
ANCHORS: Final = "anchors.txt"
#: Most faults of a dataset that one error lists.
MOST_TOLD: Final = 20
#: Largest text file.
_MAX_BYTES: Final = 64 * 2**20

_HEADER = re.compile(r"# (\w+) \| (\S[^{}]*?)(?: \{(\w+)\})?")
_PLACEMENT = re.compile(r"@ (\w+) (\w+)(?: \{([^{}]+)\})?")
_HABIT = re.compile(r"(-|[1-9](?:,[1-9])*): (\S.*)")


@dataclass
class _Draft:
    """An entry being read, with the lines that errors point at."""

    category: str
    household: str
    kind: str | None
    line: int
    placements: list[Placement] = field(default_factory=list)
    habits: list[Habit] = field(default_factory=list)
    broken: bool = False
    """Whether a line could not be read; faults that may only follow from that are not reported."""


class Faults:
    """Collects all faults of a dataset, so that one error reports them together.

    Attributes:
        found: the faults, each with file and line.
    """

    def __init__(self) -> None:
        self.found: list[str] = []

    def add(self, where: str, fault: str | None) -> bool:
        """Add a fault, unless it is None.

        Args:
            where: file and line.
            fault: what is wrong, or None.

        Returns:
            Whether there was a fault.
        """
        if fault is not None:
            self.found.append(f"{where}: {fault}")
        return fault is not None

    def raise_if_any(self, path: Path) -> None:
        """Raise an error if there are faults.

        Raises:
            DataError: one fault per line, at most the first ``MOST_TOLD``.
        """
        if len(self.found) == 1:
            raise DataError(self.found[0])
        if self.found:
            some = f", the first {MOST_TOLD}" if len(self.found) > MOST_TOLD else ""
            told = "".join(f"\n  {fault}" for fault in self.found[:MOST_TOLD])
            raise DataError(f"{path}: {len(self.found)} faults{some}:{told}")


def read_lines(path: Path) -> list[str]:
    """Read the lines of a UTF-8 text file.

    Raises:
        DataError: no such file, invalid UTF-8, or a file that does not end with a line break.
    """
    try:
        raw = read_bounded(path, _MAX_BYTES)
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); expected a habit file") from None
    return _lines(path, raw)


def _lines(path: Path, raw: bytes) -> list[str]:
    if len(raw) > _MAX_BYTES:
        raise DataError(f"{path}: more than {_MAX_BYTES:,} bytes; expected a habit file")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        bad = raw.count(b"\n", 0, error.start) + 1
        raise DataError(f"{path}:{bad}: not UTF-8 ({error.reason}); save the file as UTF-8") from None
    if not text.strip():
        raise DataError(f"{path}:1: empty; expected entries that start with '# category | household'")
    if not text.endswith("\n"):
        count = text.count("\n") + 1
        raise DataError(
            f"{path}:{count}: the last line has no line break, so the file is cut off; restore or complete it"
        )
    return text.replace("\r\n", "\n").split("\n")[:-1]


def read_anchors(path: Path, categories: Collection[str] | None = None) -> dict[str, frozenset[str]]:
    """Read a file like ``anchors.txt``, with lines ``class name: relation ...``.

    Args:
        path: the file.
        categories: names that exist; None accepts any.

    Returns:
        Allowed relations of each anchor.

    Raises:
        DataError: with all faults, each with file and line.
    """
    faults = Faults()
    anchors = _anchors(path, read_lines(path), categories, faults)
    faults.raise_if_any(path)
    return anchors


def _anchors(
    path: Path, lines: Sequence[str], categories: Collection[str] | None, faults: Faults
) -> dict[str, frozenset[str]]:
    """The anchors of a file. A line with a fault still defines its anchor, so that its uses are not reported too."""
    anchors: dict[str, frozenset[str]] = {}
    for number, line in enumerate(lines, 1):
        where = f"{path}:{number}"
        if faults.add(where, line_fault(line)) or not line.strip() or line.startswith("#"):
            continue
        match = re.fullmatch(r"[ABMS] (\w+):((?: \w+)+)", line)
        if match is None:
            faults.add(where, f"'{line[:60]}', expected 'A|B|M|S anchor: relation ...'")
            continue
        name, relations = match[1], frozenset(match[2].split())
        unknown = sorted(relations - set(RELATIONS))
        if categories is not None and name not in categories:
            faults.add(where, unknown_name("category", name, categories))
        for relation in unknown:
            faults.add(where, unknown_name("relation", relation, RELATIONS))
        if name in anchors:
            faults.add(where, f"anchor '{name}' is listed twice; keep one line")
        anchors[name] = frozenset(RELATIONS) if unknown else relations
    return anchors


def parse_book(
    path: Path, anchors: Anchors, categories: Collection[str] | None = None, limits: Limits = BOOK_LIMITS
) -> list[Entry]:
    """Read the entries of one file.

    Args:
        path: the file; entry ids are ``category/number``.
        anchors: allowed relations of each anchor.
        categories: target categories that exist; None accepts any name.
        limits: least and most placements, habits and words.

    Raises:
        DataError: with all faults, each with file and line.
    """
    faults = Faults()
    entries = _entries(path, read_lines(path), anchors, categories, {}, limits, faults)
    faults.raise_if_any(path)
    return entries


def _entries(
    path: Path,
    lines: Sequence[str],
    anchors: Anchors,
    categories: Collection[str] | None,
    count: dict[str, int],
    limits: Limits,
    faults: Faults,
) -> list[Entry]:
    """The entries of a file.

    ``count``, the number of earlier entries of each category, is updated. Lines with faults are left out; faults of
    other lines that may only follow from that are not reported.
    """
    entries: list[Entry] = []
    draft: _Draft | None = None
    for number, line in enumerate(lines, 1):
        if not line or line.isspace():
            continue
        where = f"{path}:{number}"
        unread = faults.add(where, line_fault(line))
        if line[0] == "#":
            if draft is not None:
                entries.append(_finish(path, draft, count, limits, faults))
            draft = (
                _Draft("", "", None, number, broken=True)
                if unread
                else _header(where, line, number, categories, faults)
            )
        elif draft is None:
            faults.add(where, f"'{line[:60]}' before the first entry; expected '# category | household'")
            draft = _Draft("", "", None, number, broken=True)
        elif unread:
            draft.broken = True
        elif line[0] == "@":
            _placement(where, line, draft, anchors, faults)
        else:
            _habit(where, line, draft, limits, faults)
    if draft is None:
        faults.add(f"{path}:{len(lines)}", "no entry; expected '# category | household'")
    else:
        entries.append(_finish(path, draft, count, limits, faults))
    return entries


def _header(where: str, line: str, number: int, categories: Collection[str] | None, faults: Faults) -> _Draft:
    match = _HEADER.fullmatch(line)
    if match is None:
        faults.add(where, f"bad header '{line[:60]}', expected '# category | household'")
        return _Draft("", "", None, number, broken=True)
    faults.add(where, header_fault(match[1], match[2], match[3], categories))
    return _Draft(match[1], match[2], match[3], number)


def _placement(where: str, line: str, draft: _Draft, anchors: Anchors, faults: Faults) -> None:
    match = _PLACEMENT.fullmatch(line)
    if match is None:
        faults.add(where, f"bad placement '{line[:60]}', expected '@ relation anchor' or '@ ... {{context}}'")
        draft.broken = True
        return
    if draft.habits:
        if not draft.broken:
            faults.add(where, "placement after habits; list all placements of an entry first")
        draft.broken = True
        return
    placement = Placement(cast(Relation, match[1]), match[2], match[3])
    faults.add(where, placement_fault(draft.category, draft.placements, placement, anchors))
    draft.placements.append(placement)


def _habit(where: str, line: str, draft: _Draft, limits: Limits, faults: Faults) -> None:
    match = _HABIT.fullmatch(line)
    if match is None:
        faults.add(where, f"bad habit '{line[:60]}', expected '-: sentence' or '1,3: sentence'")
        draft.broken = True
        return
    supports = () if match[1] == "-" else tuple(int(digit) - 1 for digit in match[1].split(","))
    known = limits.placements[1] if draft.broken else len(draft.placements)
    faults.add(where, habit_fault(match[2], supports, known, limits))
    draft.habits.append(Habit(match[2], supports))


def _finish(path: Path, draft: _Draft, count: dict[str, int], limits: Limits, faults: Faults) -> Entry:
    fault = None if draft.broken else count_fault(len(draft.placements), len(draft.habits), limits)
    if fault is not None:
        faults.add(f"{path}:{draft.line}", f"entry '{draft.category}' has {fault}; is the file cut off?")
    number = count.get(draft.category, 0)
    count[draft.category] = number + 1
    return Entry(
        f"{draft.category}/{number}",
        draft.category,
        draft.household,
        tuple(draft.placements),
        tuple(draft.habits),
        kind=draft.kind,
    )


@cache
def book_anchors() -> dict[str, frozenset[str]]:
    """The anchors of the shipped book with the relations they allow; read once."""
    path = BOOK_FOLDER / ANCHORS
    faults = Faults()
    anchors = _anchors(path, _lines(path, read_verified(path)), None, faults)
    faults.raise_if_any(path)
    return anchors


@cache
def book() -> HabitDataset:
    """The shipped habit book: 24,423 habits of 497 categories, checked against its checksum; read once."""
    return load_dataset_file(BOOK_FILE, verified=True)


@cache
def contexts_book() -> HabitDataset:
    """The shipped book with its second part, entries whose placements differ by context; read once.

    The second part takes the place of all other entries of its categories, so that a household has several places for
    each such thing. Its entries belong to the parts val (categories of val) and test (all others): nothing is trained
    on them.
    """
    first, second = book(), load_dataset_file(CONTEXTS_FILE, verified=True)
    own = set(second.categories)
    count = {name: len(first.entries_of(name)) if name in first.categories else 0 for name in own}
    added = tuple(replace(e, id=f"{e.category}/{count[e.category]}") for e in second.entries)
    return HabitDataset(
        "contexts",
        (*(e for e in first.entries if e.category not in own), *added),
        verdicts=Verdicts({**first.verdicts.of, **second.verdicts.of}),
        parts={e.id: "val" if category_split(e.category) == "val" else "test" for e in added},
    )


def _pickled(dataset: HabitDataset) -> Any:
    """Pickle the shipped books by name, since every installation has them, and other datasets by content."""
    if is_the_one(book, dataset):
        return the_book, (dataset.sha256,)
    if is_the_one(contexts_book, dataset):
        return the_book, (dataset.sha256, True)
    return dataset.__reduce_ex__(4)


copyreg.pickle(HabitDataset, _pickled)


def the_book(sha256: str, contexts: bool = False) -> HabitDataset:
    """A shipped book, for unpickling.

    Args:
        sha256: hash of the book when it was pickled.
        contexts: the book with its second part.

    Raises:
        DataError: this installation has another edition.
    """
    found = contexts_book() if contexts else book()
    if found.sha256 != sha256:
        raise DataError(
            f"pickled with the habit book {sha256[:12]}, here it is {found.sha256[:12]}; load it where it was made"
        )
    return found


def _read(path: Path, verified: bool) -> list[str]:
    return _lines(path, read_verified(path)) if verified else read_lines(path)


def read_book(folder: Path, categories: Collection[str] | None = None, *, verified: bool = False) -> HabitDataset:
    """Read all ``*.txt`` of a folder in name order, with its ``anchors.txt`` (the book's, where it has none).

    The limits of the shipped book apply to that book alone.

    Args:
        folder: the folder.
        categories: names that exist; None accepts any.
        verified: check each file against the folder's manifest; otherwise an edited file is read as it is.

    Raises:
        DataError: with all faults, each with file and line.
    """
    if folder.is_file():
        raise DataError(
            f"{folder}: a file; a book is a folder of *.txt files, give the folder {folder.absolute().parent}"
        )
    shipped = {BOOK_FOLDER.resolve(), CONTEXTS_FOLDER.resolve()}
    limits = BOOK_LIMITS if folder.resolve() in shipped else OWN_LIMITS
    own, faults = folder / ANCHORS, Faults()
    anchors = _anchors(own, _read(own, verified), categories, faults) if own.is_file() else book_anchors()
    paths = sorted(path for path in folder.glob("*.txt") if path.name != ANCHORS)
    if not paths:
        raise DataError(f"{folder}: no habit file (*.txt); expected files of the habit book's format")
    entries: list[Entry] = []
    count: dict[str, int] = {}
    for path in paths:
        try:
            lines = _read(path, verified)
        except DataError as error:
            faults.found.append(str(error))
        else:
            entries += _entries(path, lines, anchors, categories, count, limits, faults)
    faults.raise_if_any(folder)
    return HabitDataset("book" if folder == BOOK_FOLDER else folder.name, tuple(entries))
