"""Cost against size: sizes are as stated, the retrievers' own rankings are timed, and knowledge bases are read once."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ucon.__main__ import main
from ucon.evaluation import bench_scaling
from ucon.evaluation.bench_scaling import HOMES, RETRIEVERS, query_costs, scaled_base
from ucon.habits.book import book
from ucon.language.store import shipped_table
from ucon.readers.conditions.condition_reader import default_conditions
from ucon.retrieval.bm25 import BM25Retriever
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.told import ToldRetriever, lifted
from ucon.sim.cache import load_house
from ucon.task.sets import load_episodes


def test_knowledge_bases_have_the_size_that_is_said() -> None:
    whole = len(book())
    small, large = scaled_base(100, named=True), scaled_base(2 * whole + 50, named=True)
    assert (len(small), len(large)) == (100, 2 * whole + 50)
    assert set(small.texts) <= set(book().texts)
    assert len(set(large.texts)) == len(set(book().texts)) * 2 + 50, "who says it tells sentences apart"
    assert sorted(large.rows) == list(range(len(large)))
    assert all(shipped_table().row(text) >= 0 for text in scaled_base(whole + 50, named=False).texts[-200:])


def test_every_retriever_is_measured_at_every_size() -> None:
    costs = query_costs((50, 400), queries=3)
    assert [(cost.retriever, cost.sentences) for cost in costs] == [(n, size) for n in RETRIEVERS for size in (50, 400)]
    assert all(0 < cost.query_ms <= cost.query_ms_worst for cost in costs)
    assert all(cost.first_ms > 0 < cost.reset_ms for cost in costs)


def test_rankings_that_are_measured_are_the_retrievers_own() -> None:
    for name, retriever in (("minilm", DenseRetriever()), ("bm25", BM25Retriever())):
        base = scaled_base(300, named=name == "bm25")
        found = bench_scaling._ranking(name, base, bench_scaling._Retrievers())("mug")
        assert np.array_equal(found, retriever.rank("mug", base))
        assert np.array_equal(np.sort(found), np.arange(300))


def test_sentences_are_read_once_for_a_told_context(monkeypatch: pytest.MonkeyPatch) -> None:
    base, dense, conditions, times = scaled_base(200, named=False), DenseRetriever(), default_conditions(), []
    read = conditions.weights
    known = base.in_order
    weights = known.shuffled(read(known.base.texts, bench_scaling._TOLD, "retrieval"))
    monkeypatch.setattr(conditions, "weights", lambda *asked: times.append(asked) or read(*asked))
    told = ToldRetriever(dense, bench_scaling._TOLD, conditions)
    for target in ("mug", "umbrella", "mug"):
        plain = dense.scores(target, base, bench_scaling._TOLD.occasion_and_user)
        assert np.array_equal(told.scores(target, base), lifted(plain, weights))
    told.rank("mug", scaled_base(100, named=False))
    assert [len(asked[0]) for asked in times] == [200, 100]


def test_homes_differ_in_things_and_rooms_and_are_in_mini() -> None:
    assert set(HOMES) <= {episode.scene for episode in load_episodes("mini")}
    sizes = {(load_house(name).n_items, len(load_house(name).spec.rooms)) for name in HOMES}
    assert len(sizes) == len(HOMES) >= 8


def test_a_table_a_plot_and_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("ucon.evaluation.bench_env._STEPS", 20)
    monkeypatch.setattr(bench_scaling, "_ROUNDS", 1)
    monkeypatch.setattr(bench_scaling, "SIZES", (20, 60))
    monkeypatch.setattr(bench_scaling, "QUERIES", 2)
    monkeypatch.setattr(bench_scaling, "HOMES", HOMES[:3])
    assert main(["bench", "--scaling", "--json", "--plot", str(tmp_path)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["query_embedding_ms"] > 0
    assert [row["sentences"] for row in found["retrieval"]] == [20, 60] * len(RETRIEVERS)
    houses = {name: load_house(name) for name in HOMES[:3]}
    told = {row["home"]: (row["things"], row["rooms"]) for row in found["steps"]}
    assert told == {name: (house.n_items, len(house.spec.rooms)) for name, house in houses.items()}
    assert all(0 < row["step_ms"] < 1000 for row in found["steps"])
    assert [row["things"] for row in found["steps"]] == sorted(row["things"] for row in found["steps"])
    drawn = sorted(path.name for path in tmp_path.iterdir())
    assert drawn == ["scaling_rooms.png", "scaling_sentences.png", "scaling_things.png"]
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in drawn)
    assert main(["bench", "--scaling"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1 + 2 * len(RETRIEVERS) + 1 + 1 + 3 + 2
    assert lines[-2].startswith("CPU time")


def test_plots_are_of_scaling_alone(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["bench", "--plot", str(tmp_path)]) != 0
    assert capsys.readouterr().err.strip().endswith("bench --plot: only cost against size is drawn; add --scaling")
