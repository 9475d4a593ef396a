"""Habits as values: sentences, placements, entries of households, datasets.

Every habit of a dataset has a row number, counted through the entries in order. Embedding tables, knowledge bases and
observations refer to habits by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.sharing import Shared
from ucon.habits.verdicts import NO_VERDICTS, Verdicts
from ucon.objects.model import Relation

HOUSEHOLD_KINDS: tuple[str, ...] = ("office", "shop", "restaurant", "garden")
"""Kinds of home that entries may be bound to; ``garden`` is any home with a garden, garage or sauna."""


@dataclass(frozen=True, slots=True)
class Placement:
    """A place where an object may be: a relation to an anchor category, perhaps only in a context."""

    relation: Relation
    anchor: str
    context: str | None = None


@dataclass(frozen=True, slots=True)
class Habit:
    """One sentence; ``supports`` are indices (from 0) into its entry's placements, empty for a distractor."""

    text: str
    supports: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Entry:
    """One household's placements and habits for one category.

    Attributes:
        id: unique in its dataset.
        category: of the object.
        household: description of the people. Observations have it only as the asker, where an episode states its
            context.
        placements: where the object may be.
        habits: sentences about it.
        scene: the home it is bound to; None: any.
        kind: the kind of home it is bound to (:data:`HOUSEHOLD_KINDS`); None: any.
    """

    id: str
    category: str
    household: str
    placements: tuple[Placement, ...]
    habits: tuple[Habit, ...]
    scene: str | None = None
    kind: str | None = None


@dataclass(frozen=True, eq=False)
class HabitDataset(Shared):
    """Entries with flat row numbers. Equal contents have equal ``sha256``, whatever file they came from."""

    name: str
    entries: tuple[Entry, ...]
    labelled: bool = True
    """Whether ``supports`` is known; the official release does not say which habit supports which placement."""
    verdicts: Verdicts = NO_VERDICTS
    """Which placements PyBullet could realise. It decides what is sampled, not which habits are given, so it is not
    part of the hash."""
    standing: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Categories in each scene, where the source lists them. Not part of the hash."""
    parts: Mapping[str, str] = field(default_factory=dict)
    """Part (train, val, test) of entries, by id, where it is not left to the hash (:mod:`ucon.habits.splits`). Not part
    of the hash."""

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of all entries, in hexadecimal."""
        content = [
            (
                (e.id, e.category, e.household, e.scene, e.kind),
                [(p.relation, p.anchor, p.context) for p in e.placements],
                [(h.text, h.supports) for h in e.habits],
            )
            for e in self.entries
        ]
        return sha256_bytes(canonical_json(content).encode())

    @cached_property
    def habits(self) -> tuple[Habit, ...]:
        """All habits by row."""
        return tuple(habit for entry in self.entries for habit in entry.habits)

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """All sentences by row."""
        return tuple(habit.text for habit in self.habits)

    @cached_property
    def first_row(self) -> NDArray[np.int32]:
        """(n_entries + 1,) row of each entry's first habit, and the number of rows at the end."""
        return np.cumsum([0] + [len(e.habits) for e in self.entries], dtype=np.int32)

    @cached_property
    def row_entry(self) -> NDArray[np.int32]:
        """(n_rows,) number of each row's entry."""
        return np.repeat(np.arange(len(self.entries), dtype=np.int32), np.diff(self.first_row))

    @cached_property
    def row_category(self) -> NDArray[np.int32]:
        """(n_rows,) index into :attr:`categories` of each row."""
        index = {category: i for i, category in enumerate(self.categories)}
        return np.asarray([index[e.category] for e in self.entries], np.int32)[self.row_entry]

    @cached_property
    def categories(self) -> tuple[str, ...]:
        """Target categories, sorted."""
        return tuple(sorted({e.category for e in self.entries}))

    @cached_property
    def scenes(self) -> tuple[str, ...]:
        """Scenes that entries are bound to, in order of appearance; empty for the habit book."""
        return tuple(dict.fromkeys(e.scene for e in self.entries if e.scene is not None))

    @cached_property
    def anchors(self) -> tuple[str, ...]:
        """Anchor categories of all placements, sorted."""
        return tuple(sorted({p.anchor for e in self.entries for p in e.placements}))

    @cached_property
    def entry_number(self) -> dict[str, int]:
        """Number of each entry, by its id."""
        return {entry.id: i for i, entry in enumerate(self.entries)}

    @cached_property
    def _by_category(self) -> dict[str, tuple[Entry, ...]]:
        found: dict[str, list[Entry]] = {}
        for entry in self.entries:
            found.setdefault(entry.category, []).append(entry)
        return {category: tuple(entries) for category, entries in found.items()}

    def __len__(self) -> int:
        return len(self.texts)

    def entries_of(self, category: str, scene: str | None = None) -> tuple[Entry, ...]:
        """Entries of a category.

        Args:
            category: the category.
            scene: leave out entries that are bound to another scene; None keeps all.

        Raises:
            ConfigError: no entry has this category.
        """
        if category not in self._by_category:
            raise ConfigError(unknown_name("target category", category, self.categories, remedy=f"({self.name})"))
        entries = self._by_category[category]
        return entries if scene is None else tuple(e for e in entries if e.scene in (None, scene))

    def rows_of_entries(self, entries: Sequence[Entry]) -> NDArray[np.int32]:
        """Rows of the habits of some entries, in the order of the entries.

        Returns:
            (n,) int32.
        """
        numbers = [self.entry_number[e.id] for e in entries]
        parts = [np.arange(self.first_row[n], self.first_row[n + 1], dtype=np.int32) for n in numbers]
        return np.concatenate(parts) if parts else np.empty(0, np.int32)

    def entry_of(self, row: int) -> Entry:
        """The entry that a row belongs to."""
        return self.entries[self.row_entry[row]]

    def supports(self, row: int) -> tuple[Placement, ...]:
        """Placements that a habit supports; empty for a distractor and where labels are unknown."""
        placements = self.entry_of(row).placements
        return tuple(placements[i] for i in self.habits[row].supports)
