"""``compare --plot``: plots are drawn from the same records as the tables."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from omegaconf import OmegaConf

from tests.evaluation.records import record
from ucon.__main__ import main
from ucon.evaluation.figures.false_shares import draw_false_shares, false_shares
from ucon.evaluation.figures.markdown import Run, read_run
from ucon.evaluation.figures.run_plots import _by_subset

ROOT = Path(__file__).resolve().parents[2]
FIRST, SECOND = ROOT / "results" / "learned-habit_policy-retrieval", ROOT / "results" / "learned-frontier"


def test_four_pictures_are_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    assert main(["compare", str(FIRST), str(SECOND), "--plot", str(tmp_path / "plots")]) == 0
    said = capsys.readouterr().err.splitlines()
    assert [Path(line).name for line in said] == ["sr_over_steps.png", "ladder.png", "differences.png", "when.png"]
    for line in said:
        image = cv2.imread(line)
        assert image.shape[1] > 1000
        assert len(np.unique(image.reshape(-1, 3), axis=0)) > 50


def test_differences_by_subset_are_paired_and_add_up() -> None:
    rows = _by_subset(read_run(FIRST), read_run(SECOND))
    whole = rows["all episodes (1000)"]
    splits = [row for name, row in rows.items() if "category" in name]
    assert whole.n == sum(row.n for row in splits) == 1000
    assert whole.mean == pytest.approx(sum(row.mean * row.n for row in splits) / 1000)
    sizes = [int(name.split("-")[0]) for name in rows if " m2 " in name and "-" in name]
    assert len(sizes) > 3
    assert sizes == sorted(sizes)


def test_learning_curves_are_drawn_or_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    runs = []
    for name, rate in (("a", 0.2), ("b", 0.4)):
        folder = tmp_path / name
        folder.mkdir()
        rows = [
            '{"step":0,"val/success_rate":0.0}',
            '{"step":1,"frames":100.0,"loss":1.0}',
            '{"step":2,"frames":200.0}',
        ]
        (folder / "metrics.jsonl").write_text("\n".join([*rows, f'{{"step":2,"val/success_rate":{rate}}}', ""]))
        runs.append(str(folder))
    assert main(["compare", *runs, "--plot", str(tmp_path)]) == 0
    assert cv2.imread(str(tmp_path / "learning_curves.png")).shape[1] > 1000
    assert main(["compare", runs[0], str(FIRST), "--plot", str(tmp_path)]) == 2
    assert "a run of train.py" in capsys.readouterr().err
    assert main(["compare", *runs, "--plot", str(tmp_path), "--json"]) == 2
    assert "--plot FOLDER alone" in capsys.readouterr().err
    assert main(["compare", *runs]) == 2
    assert "--plot" in capsys.readouterr().err
    (tmp_path / "b" / "metrics.jsonl").write_text('{"step":1,"loss":1.0}\n')
    assert main(["compare", *runs, "--plot", str(tmp_path)]) == 2
    assert "no validation figures" in capsys.readouterr().err


def test_shares_of_false_sentences_make_lines_on_common_episodes(tmp_path: Path) -> None:
    """Lines are grouped by kind and share of falsehoods; the baseline is the run without habits."""
    runs = {}
    for name, level, told, episodes in (
        ("true", "retrieval", {}, range(4)),
        ("half", "retrieval", {"falsehoods": "adversarial", "false_share": 0.5}, range(1, 6)),
        ("all", "retrieval", {"falsehoods": "stale", "false_share": 1.0}, range(5)),
        ("none", "none", {}, range(5)),
    ):
        (tmp_path / name).mkdir()
        config = OmegaConf.create(
            {"episodes": "mini", "agent": {}, "task": {}, "habit_level": {"name": level}, "env": {"source": told}}
        )
        (tmp_path / name / "config.yaml").write_text(OmegaConf.to_yaml(config))
        runs[tmp_path / name] = Run(name, tuple(record(k, success=k != 1, habit_level=level) for k in episodes))
    lines = false_shares(runs)
    assert {name: list(line) for name, line in lines.items()} == {
        "belief, adversarial": [0.0, 0.5],
        "belief, no habits": [0.0, 1.0],
    }
    for line in lines.values():
        assert all([r.episode for r in records] == ["e1", "e2", "e3"] for records in line.values())
    assert false_shares({folder: run for folder, run in runs.items() if run.label in ("true", "none")}) == {}
    pytest.importorskip("matplotlib")
    draw_false_shares(lines, tmp_path / "shares.png")
    assert cv2.imread(str(tmp_path / "shares.png")).shape[1] > 1000
