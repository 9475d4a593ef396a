"""Dataset files: one compressed, versioned, checksummed file holds entries, support labels and verdicts.

The first line is a header with counts and the SHA-256 of the rest; then one line per entry, then one of verdicts.
Equal datasets give equal bytes. Loading takes a fraction of a second; parsing the book's text takes longer.
"""

from __future__ import annotations

import lzma
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, Final, cast

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, read_verified, sha256_bytes, write_atomic
from ucon.core.text import is_shown
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import parse_json
from ucon.core.untrusted.unpack import UnpackError, unpack_xz
from ucon.habits.rules import OWN_LIMITS, Anchors, count_fault, habit_fault, header_fault, line_fault, placement_fault
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.habits.verdicts import Verdicts
from ucon.objects.model import RELATIONS, Relation

FORMAT: Final = "ucon-habits"
VERSION: Final = 1
SUFFIX: Final = ".habits.xz"
LICENCE: Final = "CC-BY-4.0"
_MAX_BYTES: Final = 256 * 2**20


def save_dataset(dataset: HabitDataset, path: Path, steps: dict[str, Any] | None = None) -> None:
    """Write a dataset file; equal datasets give equal bytes.

    Args:
        dataset: what to write.
        path: a name ending in ``.habits.xz``.
        steps: how the dataset was made (proposed, validated, verified), stored in the header.

    Raises:
        DataError: another ending.
    """
    require_suffix(path)
    lines = [canonical_json(_entry_row(entry)) for entry in dataset.entries]
    body = "\n".join([*lines, canonical_json(dataset.verdicts.to_json())]) + "\n"
    header = {
        "format": FORMAT,
        "version": VERSION,
        "name": dataset.name,
        "licence": LICENCE,
        "labelled": dataset.labelled,
        "entries": len(dataset.entries),
        "habits": len(dataset),
        "body_sha256": sha256_bytes(body.encode()),
        "sha256": dataset.sha256,
        "steps": steps or {},
    }
    write_atomic(path, lzma.compress(f"{canonical_json(header)}\n{body}".encode(), preset=9))


def require_suffix(path: Path) -> None:
    """Check that a name ends in ``.habits.xz``.

    Raises:
        DataError: it does not.
    """
    if not path.name.endswith(SUFFIX):
        raise DataError(f"{path}: expected a name ending in {SUFFIX}")


def load_dataset_file(path: Path, categories: Collection[str] | None = None, *, verified: bool = False) -> HabitDataset:
    """Load a dataset file.

    Args:
        path: the file.
        categories: names of targets and anchors that exist; None accepts any name.
        verified: check the file against its folder's manifest, and skip the rules for its entries.

    Raises:
        DataError: no such file, a truncated or altered one, another version, or a line that is no entry or breaks a
            rule; names file and line.
    """
    lines = _lines(path, verified=verified)
    header = _header(path, lines[0])
    body = "\n".join(lines[1:])
    if sha256_bytes(body.encode()) != header["body_sha256"]:
        raise DataError(f"{path}: its contents do not match their checksum; restore the file or build it again")
    rows = lines[1:-1]  # the text ends with a line break
    if len(rows) != header["entries"] + 1:
        raise DataError(f"{path}: {len(rows) - 1} entries, the header says {header['entries']}; build it again")
    entries = tuple(_entry(row, f"{path}:{number}") for number, row in enumerate(rows[:-1], 2))
    if not verified:
        _check(path, entries, categories)
    try:
        verdicts = Verdicts.from_json(parse_json(rows[-1]))
    except (ValueError, LookupError, TypeError, AttributeError):
        raise DataError(f"{path}:{len(rows) + 1}: not a list of verdicts; build the file again") from None
    return HabitDataset(str(header["name"]), entries, labelled=bool(header["labelled"]), verdicts=verdicts)


def _lines(path: Path, *, verified: bool = False) -> list[str]:
    try:
        raw = read_verified(path) if verified else read_bounded(path, _MAX_BYTES)
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); expected a dataset file (*{SUFFIX})") from None
    try:
        return unpack_xz(raw, _MAX_BYTES).decode("utf-8").split("\n")
    except (UnpackError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: not a whole dataset file ({error}); restore it or build it again") from None


def _header(path: Path, line: str) -> dict[str, Any]:
    try:
        header = parse_json(line)
        found = (header["format"], header["version"])
        types = {"entries": int, "steps": dict, "body_sha256": str, "name": str, "labelled": bool}
        if not all(isinstance(header[key], kind) for key, kind in types.items()) or line_fault(header["name"]):
            raise TypeError("header")
    except (ValueError, LookupError, TypeError):
        raise DataError(f"{path}:1: not the header of a habit dataset; expected a file of `habits build`") from None
    if found != (FORMAT, VERSION):
        other = brief(f"{found[0]} {found[1]}")
        raise DataError(f"{path}:1: format {other}, expected {FORMAT} {VERSION}; build it again")
    return cast(dict[str, Any], header)


def _entry_row(entry: Entry) -> list[Any]:
    return [
        entry.id,
        entry.category,
        entry.household,
        entry.scene,
        entry.kind,
        [[p.relation, p.anchor, p.context] for p in entry.placements],
        [[h.text, list(h.supports)] for h in entry.habits],
    ]


def _entry(row: str, where: str) -> Entry:
    try:
        name, category, household, scene, kind, places, habits = parse_json(row)
        placements = tuple(Placement(cast(Relation, relation), anchor, told) for relation, anchor, told in places)
        sentences = tuple(Habit(text, tuple(supports)) for text, supports in habits)
        entry = Entry(name, category, household, placements, sentences, scene, kind)
        if not _usable(entry):
            raise ValueError(row)
    except (ValueError, TypeError):
        raise DataError(f"{where}: not an entry of a habit dataset; build the file again") from None
    return entry


def _check(path: Path, entries: tuple[Entry, ...], categories: Collection[str] | None) -> None:
    """Check all entries against the rules, except which relations an anchor allows: only the text says that."""
    names = {p.anchor for entry in entries for p in entry.placements} if categories is None else categories
    anchors = dict.fromkeys(names, frozenset[str](RELATIONS))
    seen: set[str] = set()
    for number, entry in enumerate(entries, 2):
        faults = _faults(entry, categories, anchors)
        fault = "another entry has this id" if entry.id in seen else next(filter(None, faults), None)
        if fault is not None:
            raise DataError(f"{path}:{number}: entry '{brief(entry.id)}': {fault}; fix its text and build it again")
        seen.add(entry.id)


def _faults(entry: Entry, categories: Collection[str] | None, anchors: Anchors) -> Iterator[str | None]:
    """What each rule says about an entry; None for a rule that is kept."""
    yield from map(line_fault, (entry.id, entry.category, entry.household, *(h.text for h in entry.habits)))
    yield from (line_fault(text) for p in entry.placements for text in (p.anchor, p.context or ""))
    yield header_fault(entry.category, entry.household, entry.kind, categories)
    yield count_fault(len(entry.placements), len(entry.habits), OWN_LIMITS)
    for i, placement in enumerate(entry.placements):
        yield placement_fault(entry.category, entry.placements[:i], placement, anchors)
    for habit in entry.habits:
        yield habit_fault(habit.text, habit.supports, len(entry.placements), OWN_LIMITS)


def _usable(entry: Entry) -> bool:
    """Whether every value has its type, and every text can be displayed."""
    texts: list[Any] = [entry.id, entry.category, entry.household, *(h.text for h in entry.habits)]
    texts += [text for p in entry.placements for text in (p.relation, p.anchor)]
    texts += [text for text in (entry.scene, entry.kind, *(p.context for p in entry.placements)) if text is not None]
    known = range(len(entry.placements))
    supports: list[Any] = [index for habit in entry.habits for index in habit.supports]
    return (
        all(isinstance(text, str) and is_shown(text) for text in texts)
        and all(type(index) is int and index in known for index in supports)
        and all(p.relation in RELATIONS for p in entry.placements)
        and bool(entry.placements and entry.habits)
    )
