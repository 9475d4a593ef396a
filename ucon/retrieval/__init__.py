"""The habit retrieval module and the habit levels: which sentences an agent is given."""

from ucon.retrieval.base import QUERY, Retriever, mrr, phrase, query_text, recall_at
from ucon.retrieval.bge import BgeRetriever
from ucon.retrieval.bm25 import BM25Retriever
from ucon.retrieval.context import ContextHabits, ContextRetriever, ContextWeights
from ucon.retrieval.dense import DenseRetriever, dataset_vectors
from ucon.retrieval.levels import LEVELS, Level, habits_at_level
from ucon.retrieval.reader import AnchorBelief, AnchorReader, Reading
from ucon.retrieval.tuned import tuned_encoder

__all__ = [
    "LEVELS",
    "QUERY",
    "AnchorBelief",
    "AnchorReader",
    "BM25Retriever",
    "BgeRetriever",
    "ContextHabits",
    "ContextRetriever",
    "ContextWeights",
    "DenseRetriever",
    "Level",
    "Reading",
    "Retriever",
    "dataset_vectors",
    "habits_at_level",
    "mrr",
    "phrase",
    "query_text",
    "recall_at",
    "tuned_encoder",
]
