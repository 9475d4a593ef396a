"""The knowledge base of an episode: the habits of its categories, shuffled (paper, section III)."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Literal
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.rng import stream
from ucon.core.sharing import Shared
from ucon.habits.types import Entry, HabitDataset

Mode = Literal["category", "task"]
MODES: tuple[Mode, ...] = ("category", "task")
#: Knowledge bases in row order that are cached per dataset; retrievers' indexes of them live as long.
_KEPT: Final = 8


@dataclass(frozen=True, eq=False)
class KnowledgeBase(Shared):
    """Rows of a dataset in random order."""

    dataset: HabitDataset
    rows: NDArray[np.int32]
    """(N,) rows of the dataset, shuffled."""

    @classmethod
    def build(
        cls, dataset: HabitDataset, drawn: Mapping[str, Sequence[Entry]], seed: int, mode: Mode = "category"
    ) -> KnowledgeBase:
        """The knowledge base of the household's entries for some categories.

        Each entry has its own random keys, so the order of two habits does not depend on the others.

        Args:
            dataset: the habits.
            drawn: entries by category.
            seed: of the order, and of the choice in mode ``task``.
            mode: ``category`` takes all entries, ``task`` one per category; :attr:`entries` says which.

        Raises:
            ConfigError: an unknown mode, or no entry.
        """
        if mode not in MODES:
            raise ConfigError(unknown_name("knowledge base mode", mode, MODES))
        chosen: list[Entry] = []
        for category in sorted(drawn):
            entries = list(drawn[category])
            if mode == "task" and len(entries) > 1:
                entries = [entries[int(stream(seed, "knowledge_base", "task", category).integers(len(entries)))]]
            chosen += entries
        if not chosen:
            raise ConfigError("empty knowledge base: no category has an entry; sample at least one")
        rows = dataset.rows_of_entries(chosen)
        keys = np.concatenate([stream(seed, "knowledge_base", "order", e.id).random(len(e.habits)) for e in chosen])
        return cls(dataset, rows[np.argsort(keys, kind="stable")])

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """The N sentences in order."""
        return tuple(self.dataset.texts[row] for row in self.rows)

    @cached_property
    def in_order(self) -> InOrder:
        """The same rows in ascending order. Retrievers index these, since each episode shuffles the same rows again."""
        order = np.argsort(self.rows, kind="stable")
        rows = self.rows[order]
        key = hashlib.blake2b(rows.tobytes(), digest_size=16).digest()
        kept = _IN_ORDER.setdefault(self.dataset, OrderedDict())
        base = kept.setdefault(key, KnowledgeBase(self.dataset, rows))
        kept.move_to_end(key)
        if len(kept) > _KEPT:
            kept.popitem(last=False)
        return InOrder(base, order)

    @cached_property
    def entries(self) -> dict[str, tuple[Entry, ...]]:
        """The entries of the habits, by category. Privileged: they hold the placements."""
        found: dict[str, list[Entry]] = {}
        for number in np.unique(self.dataset.row_entry[self.rows]):
            entry = self.dataset.entries[number]
            found.setdefault(entry.category, []).append(entry)
        return {category: tuple(entries) for category, entries in sorted(found.items())}

    def rows_about(self, target: str) -> NDArray[np.int32]:
        """Rows of the target category's habits, distractors included, in order.

        Raises:
            ConfigError: the category is not in the knowledge base.
        """
        if target not in self.entries:
            raise ConfigError(unknown_name("target of this knowledge base", target, self.entries))
        return self.rows[self.dataset.row_category[self.rows] == self.dataset.categories.index(target)]

    def without(self, category: str) -> KnowledgeBase:
        """The knowledge base without a category's habits; the others keep their order."""
        if category not in self.entries:
            return self
        keep = self.dataset.row_category[self.rows] != self.dataset.categories.index(category)
        return KnowledgeBase(self.dataset, self.rows[keep])


@dataclass(frozen=True, eq=False)
class InOrder(Shared):
    """A knowledge base in the order of its rows, one object for all shuffles of it."""

    base: KnowledgeBase
    order: NDArray[np.int64]
    """(N,) position of each row of ``base`` in the shuffled knowledge base."""

    def shuffled(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (N, ...) of the rows of ``base``, in the shuffled order."""
        out = np.empty_like(values)
        out[self.order] = values
        return out


_IN_ORDER: WeakKeyDictionary[HabitDataset, OrderedDict[bytes, KnowledgeBase]] = WeakKeyDictionary()
