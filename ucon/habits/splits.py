"""The parts train, val and test, by category and by entry.

The official release's unseen categories are in the test part wherever the habit book has them. The other categories are
assigned by a hash of the name, so that a new category never moves an old one. All entries of a val or test category
belong to its part. Of a training category two fifths of the entries are kept for testing: unseen habits of seen
categories. Priors, readers, retrievers and policies learn from ``train`` entries only, and an episode of one part uses
only entries of :data:`PARTS_USED`, so no sentence of a test episode was ever trained on.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Final, Literal, cast
from weakref import WeakKeyDictionary

from ucon.core.rng import stream
from ucon.habits.types import Entry, HabitDataset

Split = Literal["train", "val", "test"]
TEST_PERCENT, VAL_PERCENT = 12, 12
ENTRY_TEST_SHARE: Final = 0.4

PARTS_USED: Final[dict[Split, frozenset[Split]]] = {
    "train": frozenset({"train"}),
    "val": frozenset({"val", "train"}),
    "test": frozenset({"test"}),
}
"""For each part of episodes, the parts whose entries they may use. Validation may use training entries too."""

_PARTS: WeakKeyDictionary[HabitDataset, dict[str, Split]] = WeakKeyDictionary()


@cache
def _unseen() -> frozenset[str]:
    return frozenset(json.loads((Path(__file__).parent / "data" / "unseen_categories.json").read_text()))


def category_split(category: str) -> Split:
    """The part of a target category, also of one that is in no dataset."""
    if category in _unseen():
        return "test"
    value = _hash(f"split:{category}") % 100
    if value < TEST_PERCENT:
        return "test"
    return "val" if value < TEST_PERCENT + VAL_PERCENT else "train"


def split_categories(categories: Iterable[str], split: Split) -> tuple[str, ...]:
    """The categories of a part, sorted."""
    return tuple(sorted(c for c in categories if category_split(c) == split))


def entry_parts(dataset: HabitDataset) -> dict[str, Split]:
    """The part of every entry, by its id; computed once a dataset.

    Entries bound to scenes (the official release) are split by scene and category together: 12 % test, 6 % val.
    """
    if dataset not in _PARTS:
        bound = [e for e in dataset.entries if e.scene is not None]
        parts: dict[str, Split] = {e.id: _scene_part(e) for e in bound}
        for category in dataset.categories:
            free = [e for e in dataset.entries_of(category) if e.scene is None]
            parts |= _category_parts(category_split(category), free)
        parts |= cast("dict[str, Split]", dict(dataset.parts))
        _PARTS[dataset] = parts
    return _PARTS[dataset]


def entry_filter(dataset: HabitDataset, part: Split | None) -> Callable[[Entry], bool]:
    """A function that tells whether episodes of a part may use an entry.

    Args:
        dataset: of the entries.
        part: None allows all of them.
    """
    if part is None:
        return lambda _: True
    parts, used = entry_parts(dataset), PARTS_USED[part]
    return lambda entry: parts[entry.id] in used


def _category_parts(split: Split, entries: list[Entry]) -> dict[str, Split]:
    """The parts of a category's entries: of a training category, two of five are kept for testing."""
    if split != "train":
        return {e.id: split for e in entries}
    parts: dict[str, Split] = {}
    for kind in {e.kind for e in entries}:
        group = sorted((e for e in entries if e.kind == kind), key=_entry_hash)
        if len(group) == 1:
            kept = int(_entry_hash(group[0]) % 100 < 100 * ENTRY_TEST_SHARE)
        else:
            kept = max(1, round(ENTRY_TEST_SHARE * len(group)))
        parts |= {e.id: "test" if i < kept else "train" for i, e in enumerate(group)}
    return parts


def _scene_part(entry: Entry) -> Split:
    value = _hash(f"split:{entry.scene}/{entry.category}") % 100
    return "test" if value < TEST_PERCENT else "val" if value < TEST_PERCENT + 6 else "train"


def _entry_hash(entry: Entry) -> int:
    return _hash(f"entry:{entry.category}|{entry.household}|{entry.kind}")


def _hash(text: str) -> int:
    return int(hashlib.sha256(text.encode()).hexdigest()[:8], 16)


def scene_category_folds(entries: Sequence[Entry], count: int, name: str) -> list[frozenset[tuple[str, str]]]:
    """Deal the (scene, category) pairs of entries into folds, at random but always the same.

    Args:
        entries: bound to scenes.
        count: number of folds; empty ones are left out.
        name: of the dataset; decides the order.
    """
    pairs = sorted({(e.scene or "", e.category) for e in entries})
    order = stream(0, "pair folds", name).permutation(len(pairs))
    return [fold for k in range(count) if (fold := frozenset(pairs[i] for i in order[k::count]))]
