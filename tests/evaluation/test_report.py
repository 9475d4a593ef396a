"""What a run's hashes cover."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from ucon.evaluation.figures import report


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A miniature clone of the repository."""
    monkeypatch.setattr(report.ucon, "__file__", str(tmp_path / "ucon" / "__init__.py"))
    for name in (
        "ucon/__init__.py",
        "ucon/retrieval/data/reader.npz",
        "models/vtn.py",
        "models/agents/prompts/lgx.txt",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("as it was")
    return tmp_path


def hashed() -> str:
    report.code_hash.cache_clear()
    try:
        return report.code_hash()
    finally:
        report.code_hash.cache_clear()


@pytest.mark.parametrize("name", ["ucon/retrieval/data/reader.npz", "models/vtn.py", "models/agents/prompts/lgx.txt"])
def test_data_and_prompts_count_as_code_does(package: Path, name: str) -> None:
    before = hashed()
    (package / name).write_text("otherwise")
    assert hashed() != before


@pytest.mark.parametrize("name", ["ucon/__pycache__/x.pyc", "ucon/data/.x.swp", "models/runs/weights.safetensors"])
def test_what_is_not_shipped_does_not(package: Path, name: str) -> None:
    before = hashed()
    (package / name).parent.mkdir(parents=True, exist_ok=True)
    (package / name).write_text("new")
    assert hashed() == before


def test_hashes_name_the_weights_where_they_are_known() -> None:
    without, none, some = (report.run_hashes({}, [], weights) for weights in (None, [], ["a"]))
    assert "weights" not in without
    assert none.keys() == some.keys() == {*without, "weights"}
    assert none["weights"] != some["weights"]


def test_the_table_shows_both_ends_of_the_intervals() -> None:
    rates = {"success_rate": 0.5, "success_75": 0.25, "success_150": 0.375, "spl": 0.4, "soft_spl": 0.45, "steps": 99.6}
    ends = {"success_rate_ci95": [0.31, 0.69], "spl_ci95": [0.222, 0.588]}
    told = {"agent": "a", "habit_level": "gt", "n": 40, "retrieval": {"recall_20": 0.75, "mrr": None}}
    made = {**rates, **ends, **told}
    columns = [list(column.cells) for column in report.results_table([made]).columns]
    assert [cells[0] for cells in columns][2:] == [
        "40", "50.0 [31.0, 69.0]", "0.400 [0.222, 0.588]", "25.0", "37.5", "0.450", "100", "0.75", "-",
    ]  # fmt: skip
    out = io.StringIO()
    Console(file=out, width=80).print(report.results_table([made], wide=False))
    assert max(map(len, out.getvalue().splitlines())) <= 80
    for text in ("50.0 [31.0, 69.0]", "0.400 [0.222, 0.588]", "100"):
        assert text in out.getvalue()


@pytest.mark.parametrize(
    ("n", "ends", "said"),
    [
        (6, [0.61, 1.0], "6 episodes are too few to tell: SR may be anywhere from 61 to 100 %"),
        (
            50,
            [0.56, 0.82],
            "with 50 episodes SR is uncertain by about ±13 points, with episodes=test by ±3",
        ),
        (1000, [0.8, 0.85], "with 1000 episodes SR is uncertain by about ±2 points"),
    ],
)
def test_what_so_many_episodes_can_show(n: int, ends: list[float], said: str) -> None:
    assert report.precision_line({"n": n, "success_rate_ci95": ends}) == said
