"""A name that does not exist is answered in one line with the one that was meant: every group, every kind of word."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import main

ROOT = Path(__file__).parents[2]
HABIT = ["--habit", "The mug stays beside the laptop all day."]
COMMANDS = {
    "command": (["bnech"], "bench"),
    "action": (["habits", "shwo", "mug"], "show"),
    "step": (["habits", "survey", "scor", "a", "b"], "score"),
    "option": (["bench", "--jsno"], "--json"),
    "option of an action": (["episodes", "verify", "mini", "--habist", "x"], "--habits"),
    "set": (["episodes", "verify", "minni"], "mini"),
    "set to make": (["episodes", "make", "minni", "--out", "x"], "mini"),
    "set to pack": (["pack", "trian", "--out", "x"], "train"),
    "home to pack": (["pack", "Rs_imt", "--out", "x"], "Rs_int"),
    "scene": (["try", "--scene", "Rs_imt", "--object", "mug", *HABIT], "Rs_int"),
    "object": (["try", "--object", "muug", *HABIT], "mug"),
    "word of the catalogue": (["catalogue", "muug"], "mug"),
    "relation": (["try", "--object", "mug", "--place", "nexto:laptop", *HABIT], "nextto"),
    "anchor": (["try", "--object", "mug", "--place", "nextto:labtop", *HABIT], "laptop"),
    "agent to demonstrate": (["demo", "--agent", "beleif"], "belief"),
    "category": (["habits", "show", "walet"], "wallet"),
    "rules": (["info", "--task", "papr"], "paper"),
    "environment": (["check-env", "UcON-v1"], "UcON-v0"),
}
GROUPS = {
    "agent=beleif": "belief",
    "detector=yolo_wrld": "yolo_world",
    "habit_level=retreival": "retrieval",
    "retriever=minlm": "minilm",
    "language=causal": "causal_lm",
    "episodes=minni": "mini",
    "task=papr": "paper",
    "agnet=belief": "agent",
}
OF_TRAINING = {"learner=imitaton": "imitation", "collector=multi_snc": "multi_sync", "habits=offical": "official"}


@pytest.mark.parametrize("kind", COMMANDS)
def test_on_the_command_line(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words, meant = COMMANDS[kind]
    try:
        code = main(words)
    except SystemExit as end:  # argparse leaves so
        code = int(end.code or 0)
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 2
    assert line.startswith("error: ")
    assert f"did you mean {meant}" in line


@pytest.mark.slow
@pytest.mark.parametrize("word", [*GROUPS, *OF_TRAINING])
def test_of_a_script(word: str, tmp_path: Path) -> None:
    script, meant = ("train.py", OF_TRAINING[word]) if word in OF_TRAINING else ("eval.py", GROUPS[word])
    agent = ["agent=vtn"] if word in OF_TRAINING else []
    done = subprocess.run(
        [sys.executable, script, *agent, word, f"out={tmp_path}/run"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert f"did you mean {meant}" in done.stderr.splitlines()[-1]
