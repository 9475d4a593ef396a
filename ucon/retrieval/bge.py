"""Retrieval by BGE-M3, as in the paper: cosine of dense vectors, optionally with the match of lexical weights."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.files import user_cache
from ucon.core.sharing import Remembered, Shared
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import HabitDataset
from ucon.language.bge import HUB_NAME, BgeM3
from ucon.language.encoder import Progress
from ucon.language.phrases import query_text
from ucon.language.sparse import SparseFolder, SparseRows
from ucon.language.store import StoredEncoder
from ucon.retrieval.base import ranked
from ucon.retrieval.dense import DenseRetriever


class BgeRetriever(Shared):
    """Scores by a weighted sum of the cosine and the match of lexical weights.

    The match is the sum over shared tokens of the products of their weights. A dataset is encoded once, with the
    queries of all its categories; after that no process loads the model.
    """

    def __init__(
        self,
        path: str = HUB_NAME,
        dense_weight: float = 1.0,
        sparse_weight: float = 0.0,
        device: str = "cpu",
        cache: Path | None = None,
    ) -> None:
        """Set where the model is; it is loaded on first use (:class:`ucon.language.bge.BgeM3`).

        Args:
            path: folder of the model, or its name in the Hugging Face cache.
            dense_weight: of the cosine.
            sparse_weight: of the lexical match; BGE-M3's authors use 1 and 0.3. At 0 no lexical head is needed.
            device: of the network.
            cache: folder for vectors; the user's cache by default.

        Raises:
            ConfigError: a negative weight, or none above 0.
        """
        if min(dense_weight, sparse_weight) < 0 or dense_weight + sparse_weight == 0:
            raise ConfigError(
                f"retriever bge_m3: dense_weight={dense_weight}, sparse_weight={sparse_weight}; expected no negative "
                "weight and one above 0"
            )
        self.encoder = BgeM3(path, device=device)
        self._dense_weight, self._sparse_weight = dense_weight, sparse_weight
        self._cache = cache or user_cache()
        self._lexical: Remembered[HabitDataset, SparseRows] = Remembered()

    @property
    def name(self) -> str:
        """Name of the model with the start of the hash of its weights and settings."""
        return self.encoder.name

    @cached_property
    def store(self) -> StoredEncoder:
        """Dense vectors, kept on disk."""
        return StoredEncoder(self.encoder, folder=self._cache / "text")

    def prepare(self, dataset: HabitDataset, progress: Progress | None = None) -> None:
        """Encode the dataset's habits and queries where that was not done before.

        Args:
            dataset: whose habits and queries.
            progress: is called with texts done and texts in all.

        Raises:
            DataError: the model, or a part of it that the weights need, is missing or unusable.
        """
        if self._sparse_weight:
            self._sparse(dataset, progress)
        texts = _texts(dataset)
        self.store.encode_half(self.store.missing(texts), progress)

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        """Scores (N,) float64 in the order of ``kb.rows``."""
        out = np.zeros(len(kb))
        if self._sparse_weight:  # first, because it also stores the dense vectors
            out += self._sparse_weight * self._match(target, kb, told)
        if self._dense_weight:
            out += self._dense_weight * DenseRetriever(self.store).scores(target, kb, told)
        return out

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """Rows of the knowledge base, best first, (N,) int32."""
        return ranked(self.scores(target, kb), kb.rows)

    def _match(self, target: str, kb: KnowledgeBase, told: str) -> NDArray[np.float64]:
        rows, dataset = self._sparse(kb.dataset), kb.dataset
        if target in dataset.categories and not told:
            query = rows.row(len(dataset.texts) + dataset.categories.index(target))
        else:
            query = self.encoder.encode_both([query_text(target, told)])[1].row(0)
        return rows.dot(*query)[kb.rows]

    def _sparse(self, dataset: HabitDataset, progress: Progress | None = None) -> SparseRows:
        """Lexical weights of all habits by row, followed by those of every category's query."""
        if dataset not in self._lexical:

            def make(texts: Sequence[str], done: int, total: int) -> SparseRows:
                say = None if progress is None else lambda i, _: progress(done + i, total)
                vectors, rows = self.encoder.encode_both(texts, say)
                self.store.add(texts, vectors)
                return rows

            folder = SparseFolder(self._cache / "sparse" / self.encoder.sparse_name, make)
            self._lexical[dataset] = folder.rows(_texts(dataset))
        return self._lexical[dataset]


def _texts(dataset: HabitDataset) -> list[str]:
    return [*dataset.texts, *map(query_text, dataset.categories)]
