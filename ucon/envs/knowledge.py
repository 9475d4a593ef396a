"""What an agent is told: the habits of an episode at a habit level, and their embeddings."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, EpisodeError, unknown_name
from ucon.core.sharing import PartlyShared, Shared
from ucon.habits.book import book
from ucon.habits.knowledge import MODES, KnowledgeBase
from ucon.habits.types import Entry, HabitDataset
from ucon.language.encoder import Progress
from ucon.language.phrases import phrase
from ucon.language.store import StoredEncoder, default_encoder
from ucon.retrieval.base import PreparedRetriever, Retriever, mrr, recall_at
from ucon.retrieval.context import ContextHabits, ContextRetriever, ContextWeights
from ucon.retrieval.dense import DenseRetriever, dataset_vectors
from ucon.retrieval.levels import LEVELS, RANKED_LEVELS, TOP_P, habits_at_level
from ucon.sim.house import House
from ucon.task.episode import Episode


@dataclass(frozen=True, eq=False)
class Knowledge(PartlyShared):
    """The habits of one episode at one level."""

    _shared: ClassVar[frozenset[str]] = frozenset({"base", "rows", "target_embedding", "retriever", "texts"})

    base: KnowledgeBase
    rows: NDArray[np.int32]
    """(n,) rows of the dataset that the agent is given, in order."""
    target_embedding: NDArray[np.float16]
    retriever: Retriever
    target: str
    reranking: ContextHabits | None = None
    """At level ``context``: the list that follows what is seen; ``rows`` are those of the start."""

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """The sentences that the agent is given."""
        return tuple(self.base.dataset.texts[row] for row in self.rows)

    def retrieval_metrics(self) -> dict[str, float]:
        """Recall of the target's habits and reciprocal rank of the first, by this retriever in this knowledge base."""
        ranking, relevant = self.retriever.rank(self.target, self.base), self.base.rows_about(self.target)
        found = {f"recall_at_{k}": recall_at(ranking, relevant, k) for k in (10, 20)}
        return found | {"mrr": mrr(ranking, relevant)}


class HabitSource(Shared):
    """Gives every episode its habits.

    Args:
        dataset: habits by which the episodes were made; the habit book by default.
        retriever: ranks habits for level ``retrieval``; dense by default.
        mode: knowledge base of all entries of a category (``category``) or of one (``task``).
        top_p: habits given at levels ``retrieval`` and ``context``.
        encoder: makes the embeddings of observations; MiniLM by default.
        context: how strongly level ``context`` follows what is seen.
    """

    def __init__(
        self,
        dataset: HabitDataset | None = None,
        retriever: Retriever | None = None,
        mode: str = "category",
        top_p: int = TOP_P,
        encoder: StoredEncoder | None = None,
        context: ContextWeights | None = None,
    ) -> None:
        if mode not in MODES:
            raise ConfigError(unknown_name("knowledge base mode", mode, MODES))
        if top_p < 1:
            raise ConfigError(f"top_p={top_p}, expected at least 1")
        self.mode, self.top_p = mode, top_p
        self._dataset, self._retriever, self._encoder = dataset, retriever, encoder
        self._context = context

    @cached_property
    def dataset(self) -> HabitDataset:
        """The habits."""
        return self._dataset or book()

    @cached_property
    def encoder(self) -> StoredEncoder:
        """The sentence encoder of observations."""
        return self._encoder or default_encoder()

    @cached_property
    def retriever(self) -> Retriever:
        """The retriever of levels ``retrieval`` and ``context``."""
        return self._retriever or DenseRetriever(self.encoder)

    @cached_property
    def context(self) -> ContextRetriever:
        """Re-ranks at level ``context``."""
        return ContextRetriever(self.retriever, self._context)

    @property
    def table(self) -> NDArray[np.float16]:
        """(N, D) embeddings of the whole dataset, read-only."""
        return dataset_vectors(self.dataset, self.encoder)

    @property
    def dimension(self) -> int:
        """Length of an embedding."""
        return self.encoder.dim

    def prepare(self, progress: Progress | None = None, level: str = "none") -> None:
        """Make the dataset's embeddings, once for all processes: they are kept on disk. Nothing to do for the book.

        Those of the retriever only where ``level`` asks it.
        """
        dataset_vectors(self.dataset, self.encoder, progress)
        if level in RANKED_LEVELS and isinstance(self.retriever, PreparedRetriever):
            self.retriever.prepare(self.dataset, progress)

    def weights(self, level: str) -> tuple[str, ...]:
        """Names, with the start of their hashes, of the weights that decide what episodes at ``level`` are told."""
        retriever = self.retriever if level in RANKED_LEVELS else None
        asked = (retriever.name,) if isinstance(retriever, PreparedRetriever) else ()
        return (self.encoder.name, *asked)

    @staticmethod
    def check_level(level: str) -> str:
        """The level, if it exists."""
        if level not in LEVELS:
            raise ConfigError(unknown_name("habit level", level, LEVELS))
        return level

    def locations(self, episode: Episode, house: House) -> tuple[tuple[str, str, float], ...]:
        """Where the target may have been put: (relation, anchor category, probability). Privileged."""
        from ucon.task.making.living import placements_of

        ids = episode.entries if self.mode == "category" else episode.task_entries
        entries = [self.dataset.entries[self.dataset.entry_number[name]] for name in ids]
        about = [entry for entry in entries if entry.category == episode.target_category]
        found = placements_of(house, self.dataset, about, episode.context)
        counts = Counter((place.relation, place.anchor) for place in found)
        return tuple((relation, anchor, n / len(found)) for (relation, anchor), n in sorted(counts.items()))

    def knowledge(self, episode: Episode, level: str) -> Knowledge:
        """The habits of an episode at a level.

        Raises:
            EpisodeError: the episode was made with another dataset.
        """
        dataset = self.dataset
        if episode.habits_hash != dataset.sha256:
            raise EpisodeError(
                f"episode {episode.id}: made with habits '{episode.habits}' {episode.habits_hash[:12]}, the dataset in "
                f"use is '{dataset.name}' {dataset.sha256[:12]}; choose those habits or make the episodes anew"
            )
        ids = episode.entries if self.mode == "category" else episode.task_entries
        drawn: dict[str, list[Entry]] = {}
        for name in ids:
            if name not in dataset.entry_number:
                raise EpisodeError(f"episode {episode.id}: {unknown_name('entry', name, dataset.entry_number)}")
            entry = dataset.entries[dataset.entry_number[name]]
            drawn.setdefault(entry.category, []).append(entry)
        base = KnowledgeBase.build(dataset, drawn, episode.seed)
        target = episode.target_category
        return Knowledge(
            base=base,
            rows=habits_at_level(level, base, target, self.retriever, self.top_p),
            target_embedding=self.encoder.encode_half([phrase(target)])[0],
            retriever=self.retriever,
            target=target,
            reranking=ContextHabits(self.context, base, target, self.top_p) if level == "context" else None,
        )
