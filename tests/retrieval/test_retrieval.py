"""Levels and retrievers on held-out categories."""

import time

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.fitting.measures import measure_retrieval
from ucon.habits import KnowledgeBase, book, knowledge
from ucon.readers.sampled_homes import sampled_kb
from ucon.retrieval import LEVELS, BM25Retriever, DenseRetriever, habits_at_level, mrr, recall_at
from ucon.retrieval.kernels import LANES, products

RETRIEVERS = {"dense": DenseRetriever, "bm25": BM25Retriever}


@pytest.fixture(scope="module")
def kbs():
    return [sampled_kb(book(), "test", seed, "task") for seed in range(6)]


@pytest.mark.parametrize("name", RETRIEVERS)
def test_rankings(kbs, name):
    retriever = RETRIEVERS[name]()
    found = measure_retrieval(kbs, retriever)
    assert found["mrr"] > 0.8
    assert found["recall_at_20"] > 0.33
    kb = kbs[0]
    for target in kb.entries:
        rows = retriever.rank(target, kb)
        assert sorted(rows) == sorted(kb.rows)
        assert list(rows) == list(RETRIEVERS[name]().rank(target, kb))


@pytest.mark.parametrize("name", RETRIEVERS)
def test_ranking_does_not_depend_on_the_order_of_the_knowledge_base(kbs, name):
    kb = kbs[0]
    turned = KnowledgeBase(kb.dataset, np.ascontiguousarray(kb.rows[::-1]))
    for target in list(kb.entries)[:5]:
        assert list(RETRIEVERS[name]().rank(target, kb)) == list(RETRIEVERS[name]().rank(target, turned))


@pytest.mark.parametrize("name", ["dense", "bm25"])
def test_shuffles_of_a_knowledge_base_share_an_index(kbs, name, monkeypatch):
    """Scores follow the rows, and an index made for one order is not rebuilt for another."""
    kb, retriever = kbs[0], RETRIEVERS[name]()
    turned = KnowledgeBase(kb.dataset, np.random.default_rng(0).permutation(kb.rows).astype(np.int32))
    assert turned.in_order.base is kb.in_order.base
    target = next(iter(kb.entries))
    by_row = dict(zip(kb.rows.tolist(), retriever.scores(target, kb).tolist(), strict=True))
    first = dict(retriever.indexed)
    assert [by_row[row] for row in turned.rows.tolist()] == retriever.scores(target, turned).tolist()
    assert dict(retriever.indexed) == first
    assert all(retriever.indexed[base] is index for base, index in first.items())


def test_few_knowledge_bases_in_order_are_kept(kbs):
    kb, first = kbs[0], kbs[0].in_order.base
    for n in range(1, knowledge._KEPT + 1):
        KnowledgeBase(kb.dataset, kb.rows[n:]).in_order  # noqa: B018 (each is another set of rows)
    again = KnowledgeBase(kb.dataset, kb.rows.copy()).in_order.base
    assert again is not first
    assert (again.rows == first.rows).all()


@pytest.mark.timed
def test_product_of_every_half_is_exact():
    """All finite fp16 values, in the lanes and after them, are converted as NumPy does."""
    patterns = np.arange(1 << 16, dtype=np.uint16)
    patterns = patterns[np.isfinite(patterns.view(np.float16))]
    for dim in (1, LANES):
        halves = np.zeros((len(patterns), dim), np.uint16)
        halves[:, -1] = patterns
        found = np.empty(len(patterns))
        products(halves, np.ones(dim), found)
        assert np.array_equal(found, patterns.view(np.float16).astype(np.float64))


def test_product_is_summed_lane_by_lane():
    rng = np.random.default_rng(0)
    vectors = rng.normal(0, 0.05, (50, 3 * LANES + 5)).astype(np.float16)
    query, found = rng.normal(0, 0.05, vectors.shape[1]), np.empty(len(vectors))
    products(vectors.view(np.uint16), query, found)
    terms = vectors.astype(np.float64) * query
    lanes = terms[:, :LANES] + 0.0
    for start in (LANES, 2 * LANES):
        lanes += terms[:, start : start + LANES]
    in_order = np.concatenate([lanes, terms[:, 3 * LANES :]], axis=1)
    assert np.array_equal(found, np.cumsum(in_order, axis=1)[:, -1])


def test_dense_query_is_cheap(kbs):
    retriever = DenseRetriever()
    retriever.rank(next(iter(kbs[0].entries)), kbs[0])
    start = time.process_time()
    for kb in kbs:
        for target in kb.entries:
            retriever.rank(target, kb)
    assert (time.process_time() - start) / (20 * len(kbs)) < 3e-3


def test_levels(kbs):
    kb, dense = kbs[0], DenseRetriever()
    target = next(iter(kb.entries))
    assert len(habits_at_level("none", kb, target)) == 0
    assert list(habits_at_level("full", kb, target)) == list(kb.rows)
    gt = habits_at_level("gt", kb, target)
    assert {kb.dataset.entry_of(row).category for row in gt} == {target}
    assert len(gt) == sum(len(e.habits) for e in kb.entries[target])
    for p in (5, 10, 20, 40):
        assert list(habits_at_level("retrieval", kb, target, dense, p)) == list(dense.rank(target, kb)[:p])
    assert len(habits_at_level("retrieval", kb, target, dense)) == 20


def test_bad_levels(kbs):
    kb = kbs[0]
    target = next(iter(kb.entries))
    with pytest.raises(ConfigError, match="unknown habit level 'retreival': did you mean retrieval"):
        habits_at_level("retreival", kb, target)
    with pytest.raises(ConfigError, match="without a retriever"):
        habits_at_level("retrieval", kb, target)
    with pytest.raises(ConfigError, match="p=0"):
        habits_at_level("retrieval", kb, target, DenseRetriever(), 0)
    with pytest.raises(ConfigError, match="unknown target"):
        habits_at_level("gt", kb, "no_such_thing")
    assert LEVELS == ("none", "full", "gt", "retrieval", "context")
    with pytest.raises(ConfigError, match="'context' without a retriever"):
        habits_at_level("context", kb, target)


def test_metrics():
    ranking = np.asarray([4, 2, 9, 7], np.int32)
    assert mrr(ranking, [9, 7]) == pytest.approx(1 / 3)
    assert mrr(ranking, [5]) == 0
    assert recall_at(ranking, [2, 7], 2) == 0.5
    assert np.isnan(recall_at(ranking, [], 2))
