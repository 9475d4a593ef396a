"""Cost against size: of a ranking by number of sentences, of a step by number of things and rooms in the home.

Costs are CPU time of this process, which a busy machine changes little.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.progress import ticked
from ucon.core.rng import stream
from ucon.evaluation.bench_env import walked_per_second
from ucon.habits.book import book
from ucon.habits.contexts import Context
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import Entry, Habit, HabitDataset
from ucon.language.encoder import MiniLM
from ucon.language.phrases import query_text
from ucon.retrieval.bm25 import BM25Retriever
from ucon.retrieval.context import ContextRetriever
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.told import ToldRetriever
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

#: Numbers of sentences of the knowledge bases.
SIZES: Final = (100, 1_000, 10_000, 100_000)
#: Homes of the set ``mini``, named and generated, with few and many things in few and many rooms.
HOMES: Final = (
    "Benevolence_0_int", "procedural:flat:890003", "Rs_int", "Benevolence_1_int", "grocery_store_cafe",
    "Pomaria_0_int", "procedural:house:890002", "Wainscott_1_int", "restaurant_brunch",
    "procedural:house:890000", "office_large", "house_single_floor",
)  # fmt: skip
RETRIEVERS: Final = ("minilm", "bm25", "minilm, told context", "minilm, re-ranked")
"""What ranks: two retrievers, and the first one with a told context and with the re-ranking of level ``context``."""
#: Number of queries to a knowledge base after the first.
QUERIES: Final = 40
#: Number of resets that are measured.
_RESETS: Final = 5
#: Speakers named in repetitions of a sentence of the book.
_NAMES: Final = ("Ada", "Bruno", "Chidi", "Dalia", "Edith", "Farid", "Greta", "Hiro")
_TOLD: Final = Context(day=0, hour=16, season="summer", occasion="weather/rain", asker="retired teacher Ines")
#: Things seen, and the share of things of a category found empty, when a list is re-ranked.
_SEEN: Final = ("sofa", "desk", "shelf")
_EMPTIED: Final[Mapping[str, float]] = {"bed": 0.5, "desk": 1.0}
#: Walks per episode, of which the fastest counts: the others were slowed by processes that share the caches.
_ROUNDS: Final = 5

T = TypeVar("T")
Rank = Callable[[str], NDArray[np.int32]]


@dataclass(frozen=True)
class QueryCost:
    """CPU time of ranking all sentences of a knowledge base; embeddings of sentences and queries are known before."""

    retriever: str
    sentences: int
    query_ms: float
    """Median over queries."""
    query_ms_worst: float
    first_ms: float
    """The very first query, which builds the index."""
    reset_ms: float
    """First query after a reset, which shuffles the knowledge base and, with a told context, changes the context."""


@dataclass(frozen=True)
class StepCost:
    """CPU time of a step of a random walk with images in a home."""

    home: str
    rooms: int
    things: int
    """Furniture and objects of the home, without structure."""
    step_ms: float


def query_costs(sizes: Sequence[int], queries: int) -> list[QueryCost]:
    """Cost of a query by retriever and number of sentences.

    Args:
        sizes: numbers of sentences, from 1 up, such as :data:`SIZES`.
        queries: number of queries after the first; each is for a different category of the habit book.
    """
    categories = book().categories
    asked = [categories[k] for k in np.linspace(0, len(categories) - 1, queries + 1).astype(int)]
    for name in RETRIEVERS:  # compiles kernels, reads weights, encodes queries with the told context
        warm_up = _ranking(name, _base_for(name, 10), _Retrievers())
        for target in asked:
            warm_up(target)
    costs = []
    for name, size in ticked("retrieval", [(name, size) for name in RETRIEVERS for size in sizes]):
        base, retrievers = _base_for(name, size), _Retrievers()
        rank = _ranking(name, base, retrievers)
        first, *spent = [_milliseconds(rank, target) for target in asked]
        resets = [
            _milliseconds(_ranking(name, _shuffled(base, k), retrievers, replace(_TOLD, hour=k)), asked[k % len(asked)])
            for k in range(_RESETS)
        ]
        costs.append(QueryCost(name, size, *map(_short, (median(spent), max(spent), first, median(resets)))))
    return costs


def query_embedding_ms(queries: int) -> float:
    """Median CPU milliseconds in which MiniLM encodes a query that no table and no cache holds.

    Args:
        queries: number of them.
    """
    encoder = MiniLM()
    encoder.encode(["warm up"])
    asked = [query_text(category) for category in book().categories[:queries]]
    return _short(median(_milliseconds(encoder.encode, [text]) for text in asked))


def step_costs(homes: Sequence[str]) -> list[StepCost]:
    """Cost of a step with images by home, sorted by number of things; the fastest round of each episode.

    Args:
        homes: of the set ``mini``, such as :data:`HOMES`.
    """
    episodes: dict[str, list[Episode]] = {name: [] for name in homes}
    for episode in load_episodes("mini"):
        if episode.scene in episodes:
            episodes[episode.scene].append(episode)
    costs = []
    for name in ticked("steps by home", homes):
        house = load_house(name)
        rates = [
            max(walked_per_second(episode, {"observe": "pixels"}) for _ in range(_ROUNDS)) for episode in episodes[name]
        ]
        costs.append(
            StepCost(name, len(house.spec.rooms), house.n_items, _short(float(np.mean([1e3 / rate for rate in rates]))))
        )
    return sorted(costs, key=lambda cost: cost.things)


def scaled_base(size: int, *, named: bool) -> KnowledgeBase:
    """A shuffled knowledge base of ``size`` sentences.

    Args:
        size: number of sentences; up to that of the habit book they are all different.
        named: whether each repetition of a sentence names another speaker. If not, repetitions are identical, so that
            embeddings of all sentences are in the shipped table.
    """
    texts = book().texts
    draw = stream(0, "bench", "scaling")
    order = draw.permutation(len(texts))
    said = [_said(texts[order[k % len(texts)]], k // len(texts) if named else 0) for k in range(size)]
    entry = Entry("bench", book().categories[0], "", (), tuple(Habit(text) for text in said))
    return KnowledgeBase(HabitDataset("bench", (entry,)), draw.permutation(size).astype(np.int32))


def _said(text: str, turn: int) -> str:
    """A sentence as it stands in turn 0, or said by a different speaker in each later turn."""
    names = [_NAMES[(turn - 1) % len(_NAMES)], *(("again",) * ((turn - 1) // len(_NAMES)))]
    return text if turn == 0 else f"{' '.join(names)} says: {text}"


class _Retrievers:
    """Retrievers that are kept over resets, with their indexes."""

    def __init__(self) -> None:
        self.dense, self.bm25 = DenseRetriever(), BM25Retriever()
        self.context = ContextRetriever(self.dense)


def _base_for(name: str, size: int) -> KnowledgeBase:
    return scaled_base(size, named=name == "bm25")


def _shuffled(base: KnowledgeBase, number: int) -> KnowledgeBase:
    """The same sentences in another order, as at a reset."""
    order = stream(0, "bench", "scaling", "reset", number).permutation(len(base))
    return KnowledgeBase(base.dataset, base.rows[order])


def _ranking(name: str, base: KnowledgeBase, retrievers: _Retrievers, context: Context = _TOLD) -> Rank:
    """A function that ranks a knowledge base for a category."""
    if name == "bm25":
        return lambda target: retrievers.bm25.rank(target, base)
    if name == "minilm":
        return lambda target: retrievers.dense.rank(target, base)
    if name == "minilm, told context":
        told = ToldRetriever(retrievers.dense, context)
        return lambda target: told.rank(target, base)
    return lambda target: retrievers.context.rank(target, base, _SEEN, _EMPTIED)


def _milliseconds(action: Callable[[T], object], asked: T) -> float:
    started = time.process_time()
    action(asked)
    return 1e3 * (time.process_time() - started)


def _short(milliseconds: float) -> float:
    """Rounded to a microsecond."""
    return round(milliseconds, 3)
