"""The habits that an agent is given: those of an episode at a habit level, with their embeddings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, EpisodeError, brief, unknown_name
from ucon.core.sharing import PartlyShared, Shared
from ucon.envs.told.edits import Edits
from ucon.envs.told.falsehoods import ORDERS, Falsehoods
from ucon.envs.told.orders import with_orders
from ucon.habits.book import book
from ucon.habits.contexts import Context, condition_of
from ucon.habits.knowledge import MODES, KnowledgeBase
from ucon.habits.types import Entry, HabitDataset
from ucon.language.encoder import Progress
from ucon.language.phrases import phrase
from ucon.language.store import StoredEncoder, default_encoder
from ucon.retrieval.base import PreparedRetriever, Retriever, mrr, recall_at
from ucon.retrieval.context import ContextHabits, ContextRetriever, ContextWeights
from ucon.retrieval.dense import DenseRetriever, dataset_vectors
from ucon.retrieval.levels import LEVELS, RANKED_LEVELS, TOP_P, habits_at_level
from ucon.retrieval.told import ToldRetriever
from ucon.sim.house import House
from ucon.task.episode import Episode


@dataclass(frozen=True, eq=False)
class Knowledge(PartlyShared):
    """The habits of one episode at one habit level."""

    _shared: ClassVar[frozenset[str]] = frozenset({"base", "rows", "target_embedding", "retriever", "texts", "edited"})

    base: KnowledgeBase
    """All habits of the episode's household."""
    rows: NDArray[np.int32]
    """(n,) rows of the habits that the agent is given, in order; rows past the dataset's are those of ``edited``."""
    target_embedding: NDArray[np.float16]
    """(D,) embedding of the target's name."""
    retriever: Retriever
    """Ranks the habits of the knowledge base."""
    target: str
    """Category of the target."""
    reranking: ContextHabits | None = None
    """At level ``context``: the list that is ranked again as things are seen; ``rows`` is its initial state."""
    edited: tuple[str, ...] = ()
    """Sentences given in place of others; their rows follow those of the dataset."""

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """The n sentences that the agent is given."""
        said, n = self.base.dataset.texts, len(self.base.dataset)
        return tuple(said[row] if row < n else self.edited[row - n] for row in self.rows)

    def retrieval_metrics(self) -> dict[str, float]:
        """How well the retriever ranks the target's habits in this knowledge base.

        Returns:
            ``recall_at_10``, ``recall_at_20`` and ``mrr`` (reciprocal rank of the first such habit), each in [0, 1].
        """
        ranking, relevant = self.retriever.rank(self.target, self.base), self.base.rows_about(self.target)
        found = {f"recall_at_{k}": recall_at(ranking, relevant, k) for k in (10, 20)}
        return found | {"mrr": mrr(ranking, relevant)}


class HabitSource(Shared):
    """Gives every episode its habits."""

    def __init__(
        self,
        dataset: HabitDataset | None = None,
        retriever: Retriever | None = None,
        mode: str = "category",
        top_p: int = TOP_P,
        encoder: StoredEncoder | None = None,
        context: ContextWeights | None = None,
        falsehoods: str | None = None,
        false_share: float = 0.0,
        edits: str | None = None,
        tell_context: bool = True,
    ) -> None:
        """Choose dataset and retriever; embeddings are computed at first use.

        Args:
            dataset: the habits with which the episodes were made; the habit book by default.
            retriever: ranks habits at levels ``retrieval`` and ``context``; dense by default.
            mode: knowledge base of all entries of a category (``category``) or of one (``task``).
            top_p: number of habits given at levels ``retrieval`` and ``context``.
            encoder: makes the embeddings of observations; MiniLM by default.
            context: how strongly level ``context`` follows what is seen.
            falsehoods: kind of false sentences among the habits, see :class:`Falsehoods`; None: none.
            false_share: share of false sentences.
            edits: file of sentences to leave out or replace (:class:`Edits`); None: none.
            tell_context: give the context of episodes that state one to the agent and to the retriever.

        Raises:
            ConfigError: an unknown mode or kind of falsehoods, ``top_p`` below 1, a share outside [0, 1], or a share
                without a kind of falsehoods.
            DataError: the file of edits is missing or damaged.
        """
        if mode not in MODES:
            raise ConfigError(unknown_name("knowledge base mode", mode, MODES))
        if top_p < 1:
            raise ConfigError(f"top_p={top_p}, expected at least 1")
        if falsehoods is None and false_share:
            raise ConfigError(
                f"env.source.false_share={false_share}: no kind of falsehoods; give env.source.falsehoods, too"
            )
        self._falsehoods = None if falsehoods is None else Falsehoods(falsehoods, false_share)
        self._edits = None if edits is None else Edits.read(edits)
        self.mode, self.top_p = mode, top_p
        self._dataset, self._retriever, self._encoder = dataset, retriever, encoder
        self._context, self._tells = context, tell_context

    @cached_property
    def dataset(self) -> HabitDataset:
        """The habit dataset; the habit book is read at first use."""
        return self._dataset or book()

    @property
    def _sentences(self) -> HabitDataset:
        """The dataset whose rows are given: that of the episodes, with orders added if these are the falsehoods."""
        ordered = self._falsehoods is not None and self._falsehoods.kind == ORDERS
        return with_orders(self.dataset) if ordered else self.dataset

    @cached_property
    def encoder(self) -> StoredEncoder:
        """The sentence encoder of observations; loaded at first use."""
        return self._encoder or default_encoder()

    @cached_property
    def retriever(self) -> Retriever:
        """The retriever of levels ``retrieval`` and ``context``."""
        return self._retriever or DenseRetriever(self.encoder)

    def reranking(self, told: Context | None) -> ContextRetriever:
        """The retriever that re-ranks at level ``context``; one is shared by all episodes without a given context."""
        if told is not None:
            return ContextRetriever(ToldRetriever(self.retriever, told), self._context)
        return self._reranking

    @cached_property
    def _reranking(self) -> ContextRetriever:
        return ContextRetriever(self.retriever, self._context)

    @property
    def table(self) -> NDArray[np.float16]:
        """(N, D) float16 embeddings of all N sentences: of the dataset, of orders and of edits. Read-only."""
        return dataset_vectors(self._sentences, self.encoder) if self._edits is None else self._table_of_edits

    @cached_property
    def _table_of_edits(self) -> NDArray[np.float16]:
        assert self._edits is not None
        said = dataset_vectors(self._sentences, self.encoder)
        table = np.concatenate([said, self.encoder.encode_half(self._edits.texts)]) if self._edits.texts else said
        table.setflags(write=False)
        return table

    @property
    def dimension(self) -> int:
        """Length D of an embedding."""
        return self.encoder.dim

    def prepare(self, progress: Progress | None = None, level: str = "none") -> None:
        """Compute the dataset's embeddings and keep them on disk for all processes; the book's are shipped.

        Args:
            progress: called to report progress.
            level: habit level; the retriever is prepared only for levels that rank habits.
        """
        dataset_vectors(self._sentences, self.encoder, progress)
        if level in RANKED_LEVELS and isinstance(self.retriever, PreparedRetriever):
            self.retriever.prepare(self._sentences, progress)

    def weights(self, level: str) -> tuple[str, ...]:
        """Names of the weights and edits that decide which habits are given, with the start of their checksums.

        Args:
            level: habit level; the retriever counts only at levels that rank habits.
        """
        retriever = self.retriever if level in RANKED_LEVELS else None
        asked = (retriever.name,) if isinstance(retriever, PreparedRetriever) else ()
        edited = () if self._edits is None else (f"edits {self._edits.sha256[:12]}",)
        return (self.encoder.name, *asked, *edited)

    def check_edits(self, episodes: Iterable[Episode]) -> None:
        """Refuse edits that apply to none of the episodes: their ids are misspelt, or from another set.

        Args:
            episodes: the episodes that will be played.

        Raises:
            ConfigError: none of the episodes is edited.
        """
        if self._edits is not None and self._edits.episodes.isdisjoint(episode.id for episode in episodes):
            some = brief(min(self._edits.episodes))
            raise ConfigError(
                f"{self._edits.where}: edits {some}, ..., but no such episode is played; give their set or file"
            )

    @staticmethod
    def check_level(level: str) -> str:
        """Check that a habit level exists, and return it.

        Raises:
            ConfigError: there is no such habit level.
        """
        if level not in LEVELS:
            raise ConfigError(unknown_name("habit level", level, LEVELS))
        return level

    def locations(self, episode: Episode, house: House) -> tuple[tuple[str, str, float], ...]:
        """The distribution from which the target's place was drawn. Privileged.

        Args:
            episode: the episode.
            house: its home.

        Returns:
            Tuples (relation, anchor category, probability); the probabilities sum to 1.
        """
        from ucon.task.making.living import placements_of

        ids = episode.entries if self.mode == "category" else episode.task_entries
        entries = [self.dataset.entries[self.dataset.entry_number[name]] for name in ids]
        about = [entry for entry in entries if entry.category == episode.target_category]
        found = placements_of(house, self.dataset, about, episode.context)
        counts = Counter((place.relation, place.anchor) for place in found)
        return tuple((relation, anchor, n / len(found)) for (relation, anchor), n in sorted(counts.items()))

    def told(self, episode: Episode) -> Context | None:
        """The context that is given in an episode; None if it states none, or if contexts are not given."""
        return episode.context if self._tells else None

    def knowledge(self, episode: Episode, level: str) -> Knowledge:
        """The habits of an episode at a level.

        Args:
            episode: the episode.
            level: a habit level.

        Raises:
            EpisodeError: the episode was made with another dataset, its context names a user who is not in the
                household, or an edit is of a sentence that the agent is not given.
            ConfigError: edits at level ``context``, or falsehoods with a dataset without labels.
        """
        dataset = self.dataset
        if episode.habits_hash != dataset.sha256:
            raise EpisodeError(
                f"episode {episode.id}: made with habits '{episode.habits}' {episode.habits_hash[:12]}, the dataset in "
                f"use is '{dataset.name}' {dataset.sha256[:12]}; choose those habits or make the episodes again"
            )
        ids = episode.entries if self.mode == "category" else episode.task_entries
        drawn: dict[str, list[Entry]] = {}
        for name in ids:
            if name not in dataset.entry_number:
                raise EpisodeError(f"episode {episode.id}: {unknown_name('entry', name, dataset.entry_number)}")
            entry = dataset.entries[dataset.entry_number[name]]
            drawn.setdefault(entry.category, []).append(entry)
        base = KnowledgeBase.build(self._sentences, drawn, episode.seed)
        if self._falsehoods is not None:
            base = self._falsehoods.among(base, episode)
        target, told = episode.target_category, self.told(episode)
        if episode.context is not None:
            check_user(episode.context, base, f"episode {episode.id}")
        retriever = self.retriever if told is None else ToldRetriever(self.retriever, told)
        return Knowledge(
            base=base,
            rows=self._edited(episode, level, habits_at_level(level, base, target, retriever, self.top_p)),
            target_embedding=self.encoder.encode_half([phrase(target)])[0],
            retriever=retriever,
            target=target,
            reranking=ContextHabits(self.reranking(told), base, target, self.top_p) if level == "context" else None,
            edited=() if self._edits is None else self._edits.texts,
        )

    def _edited(self, episode: Episode, level: str, rows: NDArray[np.int32]) -> NDArray[np.int32]:
        """The rows that are given at a level after the edits; at level ``none`` there is nothing to edit."""
        if self._edits is None or level == "none":
            return rows
        if level == "context":
            raise ConfigError("env.source.edits: not for level context, whose list changes; choose another habit level")
        said = self._sentences.texts
        return self._edits.applied(episode.id, rows, tuple(said[row] for row in rows), len(said))


def check_user(context: Context, base: KnowledgeBase, where: str) -> None:
    """Refuse a context whose user is not among the people on whom placements of the household depend.

    Args:
        context: context of an episode.
        base: all habits of the household.
        where: names the episode in the error.

    Raises:
        EpisodeError: names the user, and the users who are known.
    """
    if context.user is None:
        return
    places = [place for entries in base.entries.values() for entry in entries for place in entry.placements]
    users = {user for place in places if place.context and (user := condition_of(place.context).user)}
    if context.user not in users:
        raise EpisodeError(f"{where}: {unknown_name('user', context.user, users or {'nobody'})}")
