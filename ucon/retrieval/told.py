"""Retrieval in a told context: the query names occasion and user, and sentences that hold move up.

Day, hour and season are not in the query: they make it similar to what everybody does at that time (measured in
``docs/decisions/retrieval.md``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Remembered, Shared
from ucon.habits.contexts import Context
from ucon.habits.knowledge import KnowledgeBase
from ucon.readers.conditions.condition_reader import ConditionReader, default_conditions
from ucon.retrieval.base import Retriever, ranked


class ToldRetriever(Shared):
    """Adds to a retriever's scores the logarithm of how much each sentence counts in the told context.

    The unit is a standard deviation of the knowledge base's scores, so it fits any retriever.
    """

    def __init__(self, retriever: Retriever, context: Context, conditions: ConditionReader | None = None) -> None:
        """Combine a retriever and a context.

        Args:
            retriever: scores by the query.
            context: the context that was told.
            conditions: says which sentences hold; the shipped reader by default.
        """
        self.retriever, self.told = retriever, context
        self._conditions = conditions or default_conditions()
        self._weights: Remembered[KnowledgeBase, NDArray[np.float64]] = Remembered()

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        """Scores (N,) float64 in the order of ``kb.rows``; ``told`` is ignored: the context's words are used."""
        plain = self.retriever.scores(target, kb, self.told.occasion_and_user)
        if kb not in self._weights:  # the same for every target, and expensive: each sentence is weighed
            known = kb.in_order  # its sentences are read once for all contexts
            self._weights[kb] = known.shuffled(self._conditions.weights(known.base.texts, self.told, "retrieval"))
        return lifted(plain, self._weights[kb])

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """Rows of the knowledge base, best first, (N,) int32."""
        return ranked(self.scores(target, kb), kb.rows)


def lifted(scores: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Scores (N,) raised by the logarithm of weights (N,), in standard deviations of the scores."""
    return scores + float(scores.std()) * np.log(weights)
