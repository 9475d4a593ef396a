"""``python -m ucon bench``: every figure has a unit, names in ``--json`` stay the same, and progress is shown."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from models.agents.frontier import FrontierAgent
from ucon.__main__ import main
from ucon.commands import bench
from ucon.evaluation import bench_batched, bench_env
from ucon.evaluation.bench_env import STAGES, bench_environment
from ucon.programs import learning_speed
from ucon.sim.cache import load_house
from ucon.sim.render.bench import bench_renderer
from ucon.task.episode import Episode

NAMES = set(bench._FIGURES)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """One home, few steps; the figures mean nothing."""

    def one(episodes: Sequence[Episode], agent: Any, on_stage: Callable[[], None]) -> dict[str, float]:
        return bench_environment(episodes[:1], agent and FrontierAgent, on_stage)

    monkeypatch.setattr(bench_env, "bench_environment", one)
    monkeypatch.setattr(bench_env, "_STEPS", 20)


def test_every_figure_is_said_with_its_unit(short: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--no-renderer"]) == 0
    told = capsys.readouterr()
    *lines, note = told.out.splitlines()
    assert note.startswith("CPU time of one process on one core")
    assert len(lines) == 11
    assert all(line.endswith((" steps a second", " choices a second", " steps a choice")) for line in lines)
    assert len({line[:52] for line in lines}) == len(lines), "one name a row"
    first, *_, last = told.err.splitlines()
    assert first == f"bench: 0 of {STAGES + 1} parts"
    assert last.startswith(f"bench: {STAGES + 1} of {STAGES + 1} parts, ")


def test_names_in_json(short: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--no-renderer", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    rendered = bench_renderer([load_house("Rs_int")], poses=2, rounds=1)
    assert {name.removesuffix("_worst") for name in (*found, *rendered)} == NAMES
    assert all(bench.said(name, value) for name, value in rendered.items())


@pytest.mark.slow
def test_many_homes_are_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name, few in {"SLOTS": 2, "_STEPS": 2, "_ROUNDS": 1, "_BATCHES": 1}.items():
        monkeypatch.setattr(bench_batched, name, few)
    monkeypatch.setattr(bench_batched, "one_per_home", lambda episodes: list(episodes[:1]))
    monkeypatch.setattr(bench_batched, "keep_freed_memory", lambda: True)  # for a process that only runs this
    assert main(["bench", "--batched", "--json"]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert found.keys() == bench._OF_BATCHES.keys()
    assert all(value > 0 for name, value in found.items() if not name.startswith("torchrl_overhead"))
    assert all(bench.said(name, value) for name, value in found.items())
    assert told.err.splitlines()[-1].startswith("bench: 3 of 3 parts")


@pytest.mark.slow
def test_learners_are_measured_with_each_number_of_workers(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    of_decisions = [f"{name}_{what}" for name in learning_speed.FROM_DECISIONS for what in learning_speed.OF_DECISIONS]
    measured = {*learning_speed.LEARNERS, *of_decisions}
    assert measured == set(bench._OF_LEARNERS)
    words, option = learning_speed.LEARNERS["hybrid_ppo_decisions_per_s"]
    small = {"hybrid_ppo_decisions_per_s": ((*words, "learner.frames=60", "learner.epochs=1"), option)}
    monkeypatch.setattr(learning_speed, "LEARNERS", small)
    monkeypatch.setattr(learning_speed, "STEPS", 1)
    monkeypatch.setattr(learning_speed, "FROM_DECISIONS", {"foresight": (2, 1), "counterfactual": (1, 2)})
    monkeypatch.setattr(bench, "_WORKERS", (1,))
    assert main(["bench", "--learning"]) == 0
    told = capsys.readouterr()
    *lines, note = told.out.splitlines()
    assert note.startswith("wall time")
    assert [float(line.split()[-4]) > 0 for line in lines] == [True] * 5
    assert all(", 1 worker " in line and line.endswith(" decisions a second") for line in lines)
    assert told.err.splitlines()[-1].startswith("bench: 3 of 3 parts")
