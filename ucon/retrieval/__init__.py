"""The habit retrieval module of the paper, and the habit levels: which sentences an agent is given.

Names are imported when they are first used (:mod:`ucon.core.lazy`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ucon.core.lazy import lazy_names

if TYPE_CHECKING:
    from ucon.language.phrases import QUERY, phrase, query_text
    from ucon.retrieval.base import Retriever, mrr, recall_at
    from ucon.retrieval.bge import BgeRetriever
    from ucon.retrieval.bm25 import BM25Retriever
    from ucon.retrieval.context import ContextHabits, ContextRetriever, ContextWeights
    from ucon.retrieval.dense import DenseRetriever, dataset_vectors
    from ucon.retrieval.levels import LEVELS, Level, habits_at_level
    from ucon.retrieval.tuned import tuned_encoder

__all__ = [
    "LEVELS",
    "QUERY",
    "BM25Retriever",
    "BgeRetriever",
    "ContextHabits",
    "ContextRetriever",
    "ContextWeights",
    "DenseRetriever",
    "Level",
    "Retriever",
    "dataset_vectors",
    "habits_at_level",
    "mrr",
    "phrase",
    "query_text",
    "recall_at",
    "tuned_encoder",
]

__getattr__ = lazy_names(
    __name__,
    {
        "ucon.language.phrases": ("QUERY", "phrase", "query_text"),
        "ucon.retrieval.base": ("Retriever", "mrr", "recall_at"),
        "ucon.retrieval.bge": ("BgeRetriever",),
        "ucon.retrieval.bm25": ("BM25Retriever",),
        "ucon.retrieval.context": ("ContextHabits", "ContextRetriever", "ContextWeights"),
        "ucon.retrieval.dense": ("DenseRetriever", "dataset_vectors"),
        "ucon.retrieval.levels": ("LEVELS", "Level", "habits_at_level"),
        "ucon.retrieval.tuned": ("tuned_encoder",),
    },
)
