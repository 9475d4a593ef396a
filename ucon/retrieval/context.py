"""Habit level ``context``: retrieval that reads the explored scene.

The list starts as the query's alone. As a home is explored, habits that speak for landmarks already seen are pulled
up and habits that speak for what was found empty are pushed down, so the places in the list go to what is still worth
reading. What a habit speaks for is the anchor reader's judgement of its text: nothing of the dataset is looked up, and
nothing is known of the home but what the agent says that it saw.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.sharing import PartlyShared, Remembered, Shared
from ucon.habits.knowledge import KnowledgeBase
from ucon.readers.anchor_reader import AnchorReader, default_reader
from ucon.retrieval.base import Retriever, ranked
from ucon.retrieval.levels import TOP_P


@dataclass(frozen=True)
class ContextWeights:
    """What a landmark changes in a habit's score, in units of the spread of the scores in the knowledge base."""

    seen: float = 1.0
    """Pull of a habit that speaks for a landmark that was seen and not found empty; it fades as that empties."""
    emptied: float = 0.25
    """Push on a habit that speaks for nothing but what was found empty."""

    def __post_init__(self) -> None:
        if min(self.seen, self.emptied) < 0:
            raise ConfigError(f"context weights seen={self.seen}, emptied={self.emptied}: expected 0 or more")


class ContextRetriever(Shared):
    """Re-ranks a retriever's list by what was seen. It keeps no state of an episode: the same facts, the same list."""

    def __init__(
        self, retriever: Retriever, weights: ContextWeights | None = None, reader: AnchorReader | None = None
    ) -> None:
        """``retriever`` scores by the query, ``reader`` says what a habit speaks for (default: the shipped one)."""
        self.retriever = retriever
        self.weights = weights or ContextWeights()
        self._reader = reader
        self._read: Remembered[KnowledgeBase, NDArray[np.float64]] = Remembered()
        self._scores: Remembered[KnowledgeBase, dict[str, NDArray[np.float64]]] = Remembered()

    @property
    def reader(self) -> AnchorReader:
        """Says which anchors a habit speaks for."""
        if self._reader is None:
            self._reader = default_reader()
        return self._reader

    def scores(
        self, target: str, kb: KnowledgeBase, seen: Collection[str] = (), emptied: Mapping[str, float] | None = None
    ) -> NDArray[np.float64]:
        """Score (N,) of every habit in the order of ``kb.rows``.

        Args:
            target: category to be found.
            kb: all habits of the household.
            seen: categories detected so far; those that are no landmarks change nothing.
            emptied: share in [0, 1] of a category's places that was looked at and did not hold the target.
        """
        known = self._scores.setdefault(kb, {})
        if target not in known:
            known[target] = self.retriever.scores(target, kb)
        base, gone = known[target], emptied or {}
        if not seen and not gone:
            return base
        empty = np.array([min(max(gone.get(name, 0.0), 0.0), 1.0) for name in self.reader.known])
        there = np.array([float(name in seen) for name in self.reader.known])
        speaks = self._speaks(kb)
        pull = self.weights.seen * (speaks @ (there * (1.0 - empty))) - self.weights.emptied * (speaks @ empty)
        return base + float(base.std()) * pull

    def rank(
        self, target: str, kb: KnowledgeBase, seen: Collection[str] = (), emptied: Mapping[str, float] | None = None
    ) -> NDArray[np.int32]:
        """All rows of the knowledge base, best first, (N,); without facts the retriever's own ranking."""
        if not seen and not emptied:
            return self.retriever.rank(target, kb)
        return ranked(self.scores(target, kb, seen, emptied), kb.rows)

    def _speaks(self, kb: KnowledgeBase) -> NDArray[np.float64]:
        """(N, A): probability that each habit speaks for each anchor that the reader knows."""
        if kb not in self._read:
            self._read[kb] = self.reader.evidence.read(kb.texts).anchor
        return self._read[kb]


class ContextHabits(PartlyShared):
    """The list of one episode: ``info["reranking"]`` of the environments.

    An agent that keeps track of what it saw calls :meth:`update` where it decides; observations follow the list. An
    agent that does not is given the query's list, as at level ``retrieval``. The rest of the knowledge base is behind
    it, and is for the retriever only.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_retriever", "_kb", "_facts", "rows"})

    def __init__(self, retriever: ContextRetriever, kb: KnowledgeBase, target: str, p: int = TOP_P) -> None:
        self._retriever, self._kb, self._target, self._p = retriever, kb, target, p
        self._facts: tuple[frozenset[str], dict[str, float]] = (frozenset(), {})
        self.rows: NDArray[np.int32] = retriever.rank(target, kb)[:p]
        """(p,) rows of the dataset, best first."""

    @property
    def texts(self) -> tuple[str, ...]:
        """The sentences, best first."""
        return tuple(self._kb.dataset.texts[row] for row in self.rows)

    def update(self, seen: Collection[str], emptied: Mapping[str, float]) -> bool:
        """Say what was seen so far, see :meth:`ContextRetriever.scores`; returns whether the list changed."""
        facts = (frozenset(seen), dict(emptied))
        if facts == self._facts:
            return False
        self._facts = facts
        rows = self._retriever.rank(self._target, self._kb, *facts)[: self._p]
        changed = not np.array_equal(rows, self.rows)
        self.rows = rows
        return changed
