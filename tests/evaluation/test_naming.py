"""Tables name agent, language model and detector; a run of an agent without habits counts for every level."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from models.agents.lgx import LGXAgent
from models.agents.random import RandomAgent
from tests.evaluation.records import played, record, store
from ucon.__main__ import main
from ucon.evaluation.figures.markdown import read_run
from ucon.evaluation.figures.report import results_table, summary
from ucon.evaluation.kept.naming import NameParts, agent_label, is_worth_comparing, level, parts_of
from ucon.language.models.encoder import EncoderModel
from ucon.perception.detectors.gt import GtDetector
from ucon.programs.sweep import print_sweep

ENCODER = "encoder (all-MiniLM-L6-v2)"
LLAMA = "causal (Llama-3.1-8B-Instruct)"


def said(agent: str, at: str = "none", **parts: Any) -> dict[str, Any]:
    return {"agent": agent, "habit_level": at} | NameParts(**parts).to_json()


def stored(folder: Path, agent: str, at: str, parts: NameParts) -> Path:
    return store(folder, [played(i, agent=agent, habit_level=at) for i in range(3)], parts)


def test_parts_are_read_off_what_plays() -> None:
    detector = GtDetector()
    assert parts_of(LGXAgent(EncoderModel()), detector) == NameParts(ENCODER, "gt", True)
    assert parts_of(RandomAgent(), detector) == NameParts(None, "gt", False)


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        ({}, "lgx"),
        ({"language_model": ENCODER, "detector": "gt"}, f"lgx + {ENCODER}"),
        ({"language_model": LLAMA, "detector": "yolo_world"}, f"lgx + {LLAMA} + yolo_world"),
        ({"detector": "noisy"}, "lgx + noisy"),
    ],
)
def test_the_name_of_a_player(parts: dict[str, Any], name: str) -> None:
    assert agent_label(said("lgx", **parts)) == name


def test_summaries_of_before_still_have_names() -> None:
    old = {"agent": "frontier", "habit_level": "full"}
    assert (agent_label(old), level(old)) == ("frontier", "full")


@pytest.mark.parametrize(
    ("a", "b", "wanted"),
    [
        (said("lgx", "gt"), said("lgx", "none"), True),
        (said("lgx", "none"), said("lgx", "gt"), False),
        (said("lgx", "context"), said("lgx", "retrieval"), True),
        (said("a", "gt"), said("b", "gt"), True),
        (said("b", "gt"), said("a", "gt"), False),
        (said("a", "gt"), said("b", "full"), False),
        (said("z", "gt"), said("a", "none", uses_habits=False), True),
        (said("a", "none", uses_habits=False), said("z", "gt"), False),
        (said("a", "full", uses_habits=False), said("b", "gt", uses_habits=False), True),
        (said("a", "full", uses_habits=False), said("a", "none", uses_habits=False), False),
        (said("a", "gt", language_model="x"), said("a", "gt", language_model="y"), True),
        (said("a", "gt", language_model="x"), said("a", "none", language_model="y"), False),
    ],
)
def test_what_is_compared(a: dict[str, Any], b: dict[str, Any], wanted: bool) -> None:
    assert is_worth_comparing(a, b) == wanted


@pytest.mark.parametrize("at", ["none", "retrieval"])
def test_the_row_of_who_reads_no_habits_names_no_level(at: str) -> None:
    made = summary([played(i, agent="random", habit_level=at) for i in range(3)], {}, NameParts(uses_habits=False))
    out = io.StringIO()
    Console(file=out, width=200).print(results_table([made]))
    (row,) = [line for line in out.getvalue().splitlines() if "random" in line]
    cells = [cell.strip() for cell in row.strip("│").split("│")]
    assert cells[:2] == ["random", "any"]
    assert cells[-2:] == ["-", "-"]  # recall and rank of habits that it never reads


def test_a_sweep_tells_models_apart_and_compares_with_who_was_played_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    stored(tmp_path / "a", "lgx", "gt", NameParts(ENCODER, "gt"))
    stored(tmp_path / "b", "lgx", "gt", NameParts(LLAMA, "noisy"))
    stored(tmp_path / "c", "frontier", "none", NameParts(None, "gt", uses_habits=False))
    monkeypatch.setenv("COLUMNS", "240")
    print_sweep(tmp_path)
    shown = capsys.readouterr().out
    for pair in (
        f"lgx + {ENCODER} gt - frontier any",
        f"lgx + {LLAMA} + noisy gt - frontier any",
        f"lgx + {LLAMA} + noisy gt - lgx + {ENCODER} gt",
    ):
        assert pair in shown


def test_labels_of_a_results_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = stored(tmp_path / "a", "lgx", "gt", NameParts(ENCODER, "gt"))
    two = stored(tmp_path / "b", "frontier", "none", NameParts(None, "noisy", uses_habits=False))
    assert read_run(one).label == f"lgx + {ENCODER}, gt"
    assert read_run(two).label == "frontier + noisy, any"
    assert main(["compare", str(one), str(two), "--markdown"]) == 0
    assert f"| (lgx + {ENCODER}, gt) - (frontier + noisy, any) | 3 |" in capsys.readouterr().out
    (one / "summary.json").write_text("[1]")
    assert main(["compare", str(one), str(two)]) == 2
    assert "no summary of a finished run" in capsys.readouterr().err


def test_records_say_what_they_said() -> None:
    """The bytes of a record do not depend on the names of parts."""
    assert "language_model" not in record(0).to_line()
    assert "detector" not in record(0).to_line()
