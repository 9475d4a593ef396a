"""Habit level ``context``: retrieval that follows what was explored.

The list starts as at level ``retrieval``. While a home is explored, habits that speak for landmarks already seen move
up and habits that speak for places found empty move down, so that the list is spent on habits still worth reading.
Which anchors a habit speaks for is the anchor reader's judgement of its text: no label of the dataset is used, and
nothing is known of the home except what the agent reports.
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
    """How strongly landmarks change a habit's score, in standard deviations of the knowledge base's scores.

    Raises:
        ConfigError: a negative weight.
    """

    seen: float = 1.0
    """Added for a habit that speaks for a landmark that was seen; falls as the landmark's places are found empty."""
    emptied: float = 0.25
    """Subtracted from a habit that speaks for what was found empty."""

    def __post_init__(self) -> None:
        if min(self.seen, self.emptied) < 0:
            raise ConfigError(f"context weights seen={self.seen}, emptied={self.emptied}: expected 0 or more")


class ContextRetriever(Shared):
    """Re-ranks a retriever's list by what was seen. It keeps no state of episodes: equal facts give equal lists."""

    def __init__(
        self, retriever: Retriever, weights: ContextWeights | None = None, reader: AnchorReader | None = None
    ) -> None:
        """Combine a retriever and a reader.

        Args:
            retriever: scores by the query.
            weights: how strongly landmarks change scores.
            reader: says which anchors a habit speaks for; the shipped one by default.
        """
        self.retriever = retriever
        self.weights = weights or ContextWeights()
        self._reader = reader
        self._read: Remembered[KnowledgeBase, NDArray[np.float64]] = Remembered()
        self._scores: Remembered[KnowledgeBase, dict[str, NDArray[np.float64]]] = Remembered()

    @property
    def reader(self) -> AnchorReader:
        """The reader that says which anchors a habit speaks for."""
        if self._reader is None:
            self._reader = default_reader()
        return self._reader

    def scores(
        self, target: str, kb: KnowledgeBase, seen: Collection[str] = (), emptied: Mapping[str, float] | None = None
    ) -> NDArray[np.float64]:
        """Scores (N,) float64 in the order of ``kb.rows``.

        Args:
            target: category that is looked for.
            kb: all habits of the household.
            seen: categories detected so far; those that are no anchors change nothing.
            emptied: by category, the share in [0, 1] of its places that was looked at without finding the target.
        """
        known = self._scores.setdefault(kb, {})
        if target not in known:
            known[target] = self.retriever.scores(target, kb)
        base, gone = known[target], emptied or {}
        if not seen and not gone:
            return base
        empty = np.array([min(max(gone.get(name, 0.0), 0.0), 1.0) for name in self.reader.known])
        there = np.array([float(name in seen) for name in self.reader.known])
        speaks = self._speaks(kb.in_order.base)
        pull = self.weights.seen * (speaks @ (there * (1.0 - empty))) - self.weights.emptied * (speaks @ empty)
        return base + float(base.std()) * kb.in_order.shuffled(pull)

    def rank(
        self, target: str, kb: KnowledgeBase, seen: Collection[str] = (), emptied: Mapping[str, float] | None = None
    ) -> NDArray[np.int32]:
        """All rows of the knowledge base, best first, (N,) int32; arguments as in :meth:`scores`.

        Without facts it is the retriever's own ranking.
        """
        if not seen and not emptied:
            return self.retriever.rank(target, kb)
        return ranked(self.scores(target, kb, seen, emptied), kb.rows)

    def _speaks(self, kb: KnowledgeBase) -> NDArray[np.float64]:
        """Probability (N, A) that each habit speaks for each anchor that the reader knows."""
        if kb not in self._read:
            self._read[kb] = self.reader.evidence.read(kb.texts).anchor
        return self._read[kb]


class ContextHabits(PartlyShared):
    """The list of one episode, ``info["reranking"]`` of the environments.

    An agent that keeps track of what it saw calls :meth:`update` before it decides; observations then follow the list.
    An agent that never calls it has the list of level ``retrieval``. The rest of the knowledge base stays hidden behind
    the list.

    Args:
        retriever: ranks the habits.
        kb: all habits of the household.
        target: category that is looked for.
        p: length of the list.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_retriever", "_kb", "_facts", "rows"})

    def __init__(self, retriever: ContextRetriever, kb: KnowledgeBase, target: str, p: int = TOP_P) -> None:
        self._retriever, self._kb, self._target, self._p = retriever, kb, target, p
        self._facts: tuple[frozenset[str], dict[str, float]] = (frozenset(), {})
        self.rows: NDArray[np.int32] = retriever.rank(target, kb)[:p]
        """(p,) int32 rows of the dataset, best first."""

    @property
    def texts(self) -> tuple[str, ...]:
        """The habits in the list, best first."""
        return tuple(self._kb.dataset.texts[row] for row in self.rows)

    def update(self, seen: Collection[str], emptied: Mapping[str, float]) -> bool:
        """Report what was seen so far, and rank again.

        Args:
            seen: categories detected so far.
            emptied: see :meth:`ContextRetriever.scores`.

        Returns:
            Whether the list changed.
        """
        facts = (frozenset(seen), dict(emptied))
        if facts == self._facts:
            return False
        self._facts = facts
        rows = self._retriever.rank(self._target, self._kb, *facts)[: self._p]
        changed = not np.array_equal(rows, self.rows)
        self.rows = rows
        return changed
