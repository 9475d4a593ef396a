"""Retrieval by sentence embeddings: the cosine of the paper's query and each habit."""

from __future__ import annotations

from collections.abc import Callable
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Remembered, Shared
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import HabitDataset
from ucon.language.phrases import query_text
from ucon.language.store import StoredEncoder, default_encoder
from ucon.retrieval.base import ranked
from ucon.retrieval.kernels import products

_VECTORS: WeakKeyDictionary[HabitDataset, dict[str, NDArray[np.float16]]] = WeakKeyDictionary()


def dataset_vectors(
    dataset: HabitDataset, encoder: StoredEncoder, progress: Callable[[int, int], None] | None = None
) -> NDArray[np.float16]:
    """Vectors of all habits of a dataset, computed once per process.

    For the habit book this is a view of the shipped table; other datasets are encoded once and kept on disk.

    Args:
        dataset: whose habits.
        encoder: of sentences.
        progress: is called with texts done and texts in all.

    Returns:
        (n_rows, D) float16, read-only.
    """
    known = _VECTORS.setdefault(dataset, {})
    if encoder.name not in known:
        vectors = encoder.table_slice(dataset.texts)
        if vectors is None:
            vectors = encoder.encode_half(dataset.texts, progress)
            vectors.flags.writeable = False
        known[encoder.name] = vectors
    return known[encoder.name]


class DenseRetriever(Shared):
    """Ranks habits by cosine, summed in float64."""

    def __init__(self, encoder: StoredEncoder | None = None, *, whole: bool = True) -> None:
        """Set the encoder.

        Args:
            encoder: of sentences; MiniLM with the shipped table by default.
            whole: True encodes a whole dataset at once. False encodes only the knowledge bases that are asked about,
                which is quicker for measuring a new encoder.
        """
        self.encoder = encoder or default_encoder()
        self._whole = whole
        self.indexed: Remembered[KnowledgeBase, NDArray[np.uint16]] = Remembered()

    @property
    def name(self) -> str:
        """Name of the encoder with the start of its weights' hash."""
        return self.encoder.name

    def prepare(self, dataset: HabitDataset, progress: Callable[[int, int], None] | None = None) -> None:
        """Encode a dataset's habits and the queries of its categories; they are kept on disk for all processes.

        Args:
            dataset: whose habits and queries.
            progress: is called with texts done and texts in all.
        """
        dataset_vectors(dataset, self.encoder, progress)
        self.encoder.encode_half([query_text(category) for category in dataset.categories], progress)

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        """Cosines (N,) float64 in the order of ``kb.rows``."""
        query = self.encoder.encode_half([query_text(target, told)])[0].astype(np.float64)
        known = kb.in_order
        vectors = self._vectors(known.base)
        scores = np.empty(len(vectors))
        products(vectors, query, scores)
        return known.shuffled(scores)

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """Rows of the knowledge base, best first, (N,) int32."""
        return ranked(self.scores(target, kb), kb.rows)

    def _vectors(self, kb: KnowledgeBase) -> NDArray[np.uint16]:
        """Bits of the fp16 vectors (N, D) of a knowledge base, cached while it lives."""
        if kb not in self.indexed:
            known = (
                dataset_vectors(kb.dataset, self.encoder)[kb.rows]
                if self._whole
                else self.encoder.encode_half(kb.texts)
            )
            self.indexed[kb] = known.view(np.uint16)
        return self.indexed[kb]
