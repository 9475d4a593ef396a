"""``python -m ucon lives table``: every run has its own column, whatever it is called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ucon.__main__ import main

RUNS = Path(__file__).parents[2] / "results"


def test_runs_of_one_agent_are_told_apart(capsys: pytest.CaptureFixture[str]) -> None:
    """A patrol is not part of an agent's name, so the names of the runs tell them apart."""
    runs = [str(RUNS / name) for name in ("resident-sightings", "resident-sightings-patrol")]
    assert main(["lives", "table", "--markdown", *runs]) == 0
    head, _, every, *_ = capsys.readouterr().out.splitlines()
    columns = [cell.strip() for cell in head.strip("|").split("|")][1:]
    assert [column.rpartition(": ")[2] for column in columns] == ["resident-sightings", "resident-sightings-patrol"]
    shown = [float(cell.split()[0]) for cell in every.strip("|").split("|")[1:]]
    kept = [json.loads((Path(run) / "summary.json").read_text())["spl"] for run in runs]
    assert shown == pytest.approx(kept, abs=6e-4)
    assert shown[0] != shown[1]
