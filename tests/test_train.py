"""``train.py`` from end to end, in processes of its own."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SMALL = ("learner=retriever", "learner.rank=2", "learner.n_kbs=1", "progress=false", "training.validate_every=2")


def train(*overrides: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "train.py", *overrides]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)


def error_line(result: subprocess.CompletedProcess[str]) -> str:
    lines = result.stderr.strip().splitlines()
    assert result.returncode == 2, result.stderr
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_mistakes_end_in_one_line(tmp_path):
    assert "no run there" in error_line(train(f"resume={tmp_path}/nothing"))
    assert not (tmp_path / "nothing").exists()
    assert "leave out training.steps=3" in error_line(train(f"resume={tmp_path}", "training.steps=3"))
    assert "unknown learner 'retreiver': did you mean retriever" in error_line(train("learner=retreiver"))


@pytest.mark.slow
def test_sigterm_saves_and_resume_gives_the_same_bytes(tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    result = train(*SMALL, "training.steps=4", f"out={whole}")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "best validation" in result.stdout
    assert {"config.yaml", "metrics.jsonl", "MODEL_CARD.md", "summary.json"} <= {p.name for p in whole.iterdir()}
    command = [sys.executable, "train.py", *SMALL, "training.steps=4", f"out={parts}"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    metrics = parts / "metrics.jsonl"
    while not (metrics.is_file() and '"step":1' in metrics.read_text()):
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 128 + signal.SIGTERM
    assert f"go on with resume={parts}" in told
    result = train(f"resume={parts}", "progress=false")
    assert result.returncode == 0, result.stderr[-2000:]
    for name in ("metrics.jsonl", "model/retriever.safetensors"):
        assert (whole / name).read_bytes() == (parts / name).read_bytes()
    summaries = [json.loads((folder / "summary.json").read_text()) for folder in (whole, parts)]
    assert summaries[0]["hashes"] == summaries[1]["hashes"]
