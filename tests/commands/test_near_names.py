"""An unknown name is answered in one line that suggests the one meant, for every group and kind of word."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.programs.composing import eval_config

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
#: Options of a group: those of the same group come first.
IN_GROUPS = {
    "agent=lgx agent.temprature=1": "did you mean agent.temperature?",
    "agent=frontier_weighted agent.wieght=1": "expected one of agent.look_around, agent.opens, agent.overhead",
    "agent=oracle agent.wieght=1": "the choice for agent has no options in its file in configs/agent/",
    "agent.min_pixels=1": "did you mean detector.min_pixels?",
    "env.widht_px=3": "did you mean env.width_px",
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
    except SystemExit as end:  # argparse exits this way
        code = int(end.code or 0)
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 2
    assert line.startswith("error: ")
    assert f"did you mean {meant}" in line


@pytest.mark.parametrize("words", IN_GROUPS)
def test_an_option_of_a_group(words: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as error:
        eval_config(*words.split(), f"out={tmp_path}")
    assert f"unknown option '{words.split()[-1].partition('=')[0]}': {IN_GROUPS[words]}" in str(error.value)


def test_nothing_is_left_where_a_command_fails_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    out = tmp_path / "out"
    for words, meant in (
        (["try", "--object", "mug", *HABIT, "--agent", "beleif", "--out", str(out)], "did you mean belief"),
        (["try", "--object", "mug", *HABIT, "--agent", "vtn", "--out", str(out)], "no trained weights"),
        (["demo", "--agent", "vtn", "--out", str(out)], "no trained weights"),
        (["episodes", "make", "mini", "--limit", "1", "--out", str(out / "x.xz")], "a name ending in .jsonl.xz"),
        (["watch", "results/learned-frontier", "episode", "--out", str(out)], "EPISODE episode"),
    ):
        assert main(words) == 2
        assert meant in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("script", ["eval.py agent=vtn", "eval.py -m agent=vtn,zson", "train.py -m training.steps=0,1"])
def test_no_folder_is_left_where_a_script_fails_at_once(script: str, tmp_path: Path) -> None:
    name, *words = script.split()
    done = subprocess.run(
        [sys.executable, name, *words, f"out={tmp_path}/run"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("error: ")
    assert list(tmp_path.iterdir()) == []


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
