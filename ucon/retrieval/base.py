"""Interface of retrievers, and measures of their rankings.

Scores are rounded to 1e-4 before they are compared, and ties go to the lower row number, so a ranking depends neither
on the last bits of a matrix product nor on the order of the knowledge base.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import HabitDataset

DECIMALS: Final = 4


class Retriever(Protocol):
    """Scores the N habits of a knowledge base for a target."""

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        """Scores (N,) float64 in the order of ``kb.rows``; larger is better.

        Args:
            target: category that is looked for.
            kb: the knowledge base.
            told: what is added to the query, such as ``when there is film night``.
        """
        ...

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """All rows of the knowledge base, best first, (N,) int32.

        Args:
            target: category that is looked for.
            kb: the knowledge base.
        """
        ...


@runtime_checkable
class PreparedRetriever(Retriever, Protocol):
    """A retriever that can encode a dataset beforehand, once for all processes."""

    @property
    def name(self) -> str:
        """Names the weights that it encodes with."""
        ...

    def prepare(self, dataset: HabitDataset, progress: Callable[[int, int], None] | None = None) -> None:
        """Encode what was not encoded before, and keep it on disk.

        Args:
            dataset: whose habits and queries.
            progress: is called with texts done and texts in all.
        """
        ...


def ranked(scores: NDArray[np.float64], rows: NDArray[np.int32]) -> NDArray[np.int32]:
    """Rows sorted by rounded score, best first; ties by row number.

    Args:
        scores: (N,).
        rows: (N,) row numbers.

    Returns:
        (N,) int32.
    """
    steps = np.rint(scores * 10**DECIMALS).astype(np.int64)
    keys = (-steps << 32) + rows  # rounded score and row in one integer, so no two are equal
    keys.sort()
    return (keys & 0xFFFFFFFF).astype(np.int32)


def recall_at(ranking: NDArray[np.int32], relevant: Collection[int] | NDArray[np.int32], k: int) -> float:
    """Share of the relevant rows among the first ``k`` of a ranking; NaN without relevant rows.

    Args:
        ranking: rows, best first.
        relevant: row numbers.
        k: length of the list.
    """
    wanted = np.asarray(list(relevant), np.int32)
    return float(np.isin(wanted, ranking[:k]).mean()) if len(wanted) else float("nan")


def mrr(ranking: NDArray[np.int32], relevant: Collection[int] | NDArray[np.int32]) -> float:
    """Reciprocal rank of the first relevant row; 0 where none is ranked.

    Args:
        ranking: rows, best first.
        relevant: row numbers.
    """
    hits = np.flatnonzero(np.isin(ranking, np.asarray(list(relevant), np.int32)))
    return 1.0 / (1 + int(hits[0])) if len(hits) else 0.0
