"""Retrieval by BGE-M3, as in the paper: cosine of dense vectors, and on demand the match of lexical weights."""

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
    """Ranks by ``dense_weight`` x cosine + ``sparse_weight`` x sum over shared tokens of the products of weights.

    A dataset is encoded once, with the queries of all its categories: afterwards no process loads the model.
    """

    def __init__(
        self,
        path: str = HUB_NAME,
        dense_weight: float = 1.0,
        sparse_weight: float = 0.0,
        device: str = "cpu",
        cache: Path | None = None,
    ) -> None:
        """The model is looked for when it is first needed, see :class:`ucon.language.bge.BgeM3`.

        Args:
            path: folder of the model, or its name in the Hugging Face cache.
            dense_weight: weight of the cosine.
            sparse_weight: weight of the lexical match; its authors mix 1 and 0.3. 0 needs no lexical head.
            device: where the network runs.
            cache: where vectors are kept; the user's cache folder by default.

        Raises:
            ConfigError: a negative weight, or none above 0.
        """
        if min(dense_weight, sparse_weight) < 0 or dense_weight + sparse_weight == 0:
            raise ConfigError(
                f"retriever bge_m3: dense_weight={dense_weight}, sparse_weight={sparse_weight}; expected no negative "
                "one and one above 0"
            )
        self.encoder = BgeM3(path, device=device)
        self._dense_weight, self._sparse_weight = dense_weight, sparse_weight
        self._cache = cache or user_cache()
        self._lexical: Remembered[HabitDataset, SparseRows] = Remembered()

    @property
    def name(self) -> str:
        """Name of the model, with the start of the hash of its weights and settings."""
        return self.encoder.name

    @cached_property
    def store(self) -> StoredEncoder:
        """Dense vectors, kept on disk."""
        return StoredEncoder(self.encoder, folder=self._cache / "text")

    def prepare(self, dataset: HabitDataset, progress: Progress | None = None) -> None:
        """Encode a dataset and its queries, where that was not done before.

        Raises:
            DataError: the model, or a part of it that the weights ask for, is not there or not usable.
        """
        if self._sparse_weight:
            self._sparse(dataset, progress)
        texts = _texts(dataset)
        self.store.encode_half(self.store.missing(texts), progress)

    def scores(self, target: str, kb: KnowledgeBase) -> NDArray[np.float64]:
        """Scores (N,) in the order of ``kb.rows``."""
        out = np.zeros(len(kb))
        if self._sparse_weight:  # first, because it leaves the dense vectors in the store too
            out += self._sparse_weight * self._match(target, kb)
        if self._dense_weight:
            out += self._dense_weight * DenseRetriever(self.store).scores(target, kb)
        return out

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        """Rows of the knowledge base, best first."""
        return ranked(self.scores(target, kb), kb.rows)

    def _match(self, target: str, kb: KnowledgeBase) -> NDArray[np.float64]:
        rows, dataset = self._sparse(kb.dataset), kb.dataset
        if target in dataset.categories:
            query = rows.row(len(dataset.texts) + dataset.categories.index(target))
        else:
            query = self.encoder.encode_both([query_text(target)])[1].row(0)
        return rows.dot(*query)[kb.rows]

    def _sparse(self, dataset: HabitDataset, progress: Progress | None = None) -> SparseRows:
        """Lexical weights of all habits by row, then of the query of every category."""
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
