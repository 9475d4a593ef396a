"""Retrieval by words: BM25 over stems, with an index that all shuffles of a knowledge base share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Remembered, Shared
from ucon.habits.knowledge import KnowledgeBase
from ucon.language.phrases import phrase
from ucon.language.words import content_stems
from ucon.retrieval.base import ranked


class BM25Retriever(Shared):
    """BM25 in Lucene's form, with the target's name as the query.

    Args:
        k1: saturation of term frequency.
        b: weight of the length of a document.
    """

    def __init__(self, k1: float = 1.5, b: float = 0.75) -> None:
        self._k1 = k1
        self._b = b
        self.indexed: Remembered[KnowledgeBase, tuple[object, dict[str, int]]] = Remembered()

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        """Scores (N,) float64 in the order of ``kb.rows``; 0 where no stem is shared."""
        known = kb.in_order
        index, vocabulary = self._indexed(known.base)
        query = [vocabulary[stem] for stem in content_stems(f"{phrase(target)} {told}") if stem in vocabulary]
        if not query:
            return np.zeros(len(kb))
        return known.shuffled(np.asarray(index.get_scores(query), np.float64))  # type: ignore[attr-defined]

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """Rows of the knowledge base, best first, (N,) int32."""
        return ranked(self.scores(target, kb), kb.rows)

    def _indexed(self, kb: KnowledgeBase) -> tuple[object, dict[str, int]]:
        if kb not in self.indexed:
            import bm25s  # type: ignore[import-untyped]

            vocabulary: dict[str, int] = {}
            documents = [[vocabulary.setdefault(s, len(vocabulary)) for s in content_stems(t)] for t in kb.texts]
            index = bm25s.BM25(k1=self._k1, b=self._b)
            index.index((documents, vocabulary), show_progress=False)
            self.indexed[kb] = (index, vocabulary)
        return self.indexed[kb]
