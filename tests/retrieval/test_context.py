"""Habit level ``context``: habits about seen things move up the list, those about empty places move down."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.habits import KnowledgeBase, book
from ucon.readers.anchor_reader import default_reader
from ucon.readers.sampled_homes import sampled_kb
from ucon.retrieval import (
    BM25Retriever,
    ContextHabits,
    ContextRetriever,
    ContextWeights,
    DenseRetriever,
    habits_at_level,
)
from ucon.retrieval.levels import FIXED_LEVELS, LEVELS, RANKED_LEVELS


@pytest.fixture(scope="module")
def kb() -> KnowledgeBase:
    return sampled_kb(book(), "val", 1, "category")


@pytest.fixture(scope="module")
def target(kb: KnowledgeBase) -> str:
    return next(iter(kb.entries))


@pytest.fixture(scope="module")
def retriever() -> ContextRetriever:
    return ContextRetriever(DenseRetriever())


def places(kb: KnowledgeBase) -> dict[str, np.ndarray]:
    """By anchor: positions in the knowledge base of habits that clearly support this anchor."""
    reader = default_reader()
    said = reader.evidence.read(kb.texts).anchor
    found = {name: np.flatnonzero(said[:, k] > 0.9) for k, name in enumerate(reader.known)}
    return {name: where for name, where in found.items() if len(where)}


def test_levels() -> None:
    assert FIXED_LEVELS == ("none", "full", "gt", "retrieval")
    assert (*FIXED_LEVELS, "context") == LEVELS
    assert set(RANKED_LEVELS) < set(LEVELS)


@pytest.mark.parametrize("base", [DenseRetriever, BM25Retriever])
def test_without_facts_it_is_retrieval(kb: KnowledgeBase, base: type) -> None:
    for name in list(kb.entries)[:5]:
        expected = base().rank(name, kb)
        retriever = ContextRetriever(base())
        assert retriever.rank(name, kb).tolist() == expected.tolist()
        assert retriever.rank(name, kb, {"no_landmark"}, {}).tolist() == expected.tolist()
        assert ContextHabits(retriever, kb, name).rows.tolist() == expected[:20].tolist()
        assert habits_at_level("context", kb, name, base()).tolist() == expected[:20].tolist()


def test_seen_landmarks_rise_and_emptied_ones_sink(kb: KnowledgeBase, target: str, retriever: ContextRetriever) -> None:
    def standing(where: int, *facts: object) -> int:
        return retriever.rank(target, kb, *facts).tolist().index(kb.rows[where])  # type: ignore[arg-type]

    for name, found in places(kb).items():
        scores = retriever.scores(target, kb)
        there, emptied = retriever.scores(target, kb, {name}), retriever.scores(target, kb, {name}, {name: 1.0})
        half = retriever.scores(target, kb, {name}, {name: 0.5})
        assert (there[found] > scores[found]).all()
        assert (emptied[found] < scores[found]).all()
        assert ((emptied[found] < half[found]) & (half[found] < there[found])).all()
        best, worst = int(found[scores[found].argmax()]), int(found[scores[found].argmin()])
        assert standing(worst, {name}) <= standing(worst)
        assert standing(best, {name}, {name: 1.0}) >= standing(best)
        silent = np.flatnonzero(default_reader().evidence.read(kb.texts).anchor.max(axis=1) < 1e-3)
        assert np.allclose(there[silent], scores[silent], atol=1e-3)


def test_only_the_facts_decide(kb: KnowledgeBase, target: str, retriever: ContextRetriever) -> None:
    names = list(places(kb))
    facts = names[:6], dict.fromkeys(names[2:4], 0.5)
    expected = retriever.rank(target, kb, *facts).tolist()
    assert sorted(expected) == sorted(kb.rows)
    turned = KnowledgeBase(kb.dataset, np.ascontiguousarray(kb.rows[::-1]))
    again = ContextRetriever(DenseRetriever())
    again.rank(target, kb, names)
    assert again.rank(target, turned, set(names[5::-1]), dict(reversed(facts[1].items()))).tolist() == expected
    assert retriever.rank(target, kb).tolist() == DenseRetriever().rank(target, kb).tolist()


def test_a_list_follows_what_it_is_told(kb: KnowledgeBase, target: str, retriever: ContextRetriever) -> None:
    habits = ContextHabits(retriever, kb, target, 10)
    first, names = habits.rows, list(places(kb))
    assert not habits.update((), {})
    assert habits.rows is first
    assert habits.update(names, {})
    assert len(habits.rows) == len(habits.texts) == 10
    assert habits.texts == tuple(book().texts[row] for row in habits.rows)
    assert not habits.update(set(names), {})
    assert habits.update((), {})
    assert habits.rows.tolist() == first.tolist()
    assert {name for name in dir(habits) if not name.startswith("_")} == {"rows", "texts", "update"}


def test_weights_of_nothing_change_nothing(kb: KnowledgeBase, target: str) -> None:
    still = ContextRetriever(DenseRetriever(), ContextWeights(0.0, 0.0))
    expected = DenseRetriever().rank(target, kb).tolist()
    assert still.rank(target, kb, list(places(kb)), {"sofa": 1.0}).tolist() == expected
    with pytest.raises(ConfigError, match="expected 0 or more"):
        ContextWeights(seen=-1.0)
