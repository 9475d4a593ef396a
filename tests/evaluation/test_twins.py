"""An agent that reads no habits is played once in a sweep, and no other run is mistaken for its twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from tests.evaluation.records import played, reseal
from tests.evaluation.records import store as store_run
from ucon.evaluation.kept.seal import CONFIG, SUMMARY
from ucon.evaluation.kept.twins import twin_of

HASHES = {"config": "c1", "episodes": "e", "habits": "h", "code": "v", "weights": "w1"}
RUN: dict[str, Any] = {
    "agent": {"_target_": "models.agents.frontier_rules.FrontierRuleAgent", "rule": "nearest", "seed": 0},
    "habit_level": {"name": "none", "top_p": 0},
    "retriever": {"_target_": "x"},
    "habits": {"path": "a"},
    "seed": 0,
    "limit": 4,
    "task": {"name": "paper"},
    "episodes": "mini",
    "out": "a",
    "workers": 2,
    "env": {"planner": "true", "habit_level": "none", "source": {"top_p": 0, "dataset": {"path": "a"}}},
}
FULL = RUN | {
    "habit_level": {"name": "full", "top_p": 20},
    "retriever": {"_target_": "y"},
    "out": "b",
    "workers": 0,
    "env": RUN["env"] | {"habit_level": "full", "source": {"top_p": 20, "dataset": {"path": "a"}}},
}


def store(folder: Path, config: dict[str, Any] = RUN, hashes: dict[str, str] = HASHES) -> Path:
    store_run(folder, [played(0)], config=OmegaConf.to_yaml(OmegaConf.create(config)))
    reseal(folder, hashes=hashes)
    return folder


def test_another_habit_level_is_the_same_run(tmp_path: Path) -> None:
    twin = store(tmp_path / "one")
    assert twin_of(tmp_path / "two", FULL, HASHES | {"config": "c2"}) == twin
    assert twin_of(twin, FULL, HASHES) is None  # a run is not its own twin
    (twin / SUMMARY).unlink()
    assert twin_of(tmp_path / "two", FULL, HASHES) is None  # not finished


@pytest.mark.parametrize("changed", ["episodes", "habits", "code", "weights"])
def test_other_episodes_habits_code_or_weights_are_another_run(changed: str, tmp_path: Path) -> None:
    store(tmp_path / "one")
    assert twin_of(tmp_path / "two", FULL, HASHES | {changed: "other"}) is None


@pytest.mark.parametrize(
    "other",
    [
        {"agent": RUN["agent"] | {"rule": "utility"}},
        {"agent": RUN["agent"] | {"seed": 1}},
        {"seed": 1},
        {"limit": 5},
        {"habits": {"path": "b"}},
        {"env": RUN["env"] | {"planner": "observed"}},
    ],
    ids=str,
)
def test_other_parameters_are_another_run(other: dict[str, Any], tmp_path: Path) -> None:
    store(tmp_path / "one")
    assert twin_of(tmp_path / "two", FULL | other, HASHES) is None


@pytest.mark.parametrize("name", [SUMMARY, CONFIG])
@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "[1]",
        "null",
        "3",
        '{"hashes": null}',
        '{"hashes": [1]}',
        "env: null",
        "env: [1]",
        "a: ${b",
        "\x00",
    ],
)
def test_a_damaged_neighbour_is_passed_over(name: str, text: str, tmp_path: Path) -> None:
    damaged, whole = store(tmp_path / "a"), store(tmp_path / "b")
    (damaged / name).write_text(text)
    assert twin_of(tmp_path / "two", FULL, HASHES) == whole
    (damaged / name).write_bytes(b"\xff\xfe\xff")
    assert twin_of(tmp_path / "two", FULL, HASHES) == whole
    (damaged / name).unlink()
    (damaged / name).mkdir()
    assert twin_of(tmp_path / "two", FULL, HASHES) == whole
