"""Impossible options of ``eval.py`` and ``train.py``: one line that names them, exit code 2, nothing played."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.programs import outcomes
from ucon.programs.ready import problem

ROOT = Path(__file__).parents[1]
LONG = "a" * 300
QUICK = ("agent=random", "habit_level=none", "limit=1", "pictures=0", "workers=0", "progress=false")
SWITCH = "expected true or false"
WHOLE = "expected a whole number from 0 up"
TEXT = "expected a text"
HOW = "run `make setup`, then `source .venv/bin/activate`"

OF_EVAL = [
    ("task.context=no", f"task.context=no: {SWITCH}"),
    ("task.context=off", f"task.context=off: {SWITCH}"),
    ("task.context=x", f"task.context=x: {SWITCH}"),
    ("task.context=1", f"task.context=1: {SWITCH}"),
    ("task.name={}", f"task.name={{}}: {TEXT}"),
    ("task.name=papr", "did you mean paper"),
    ("seed=-1", f"seed=-1: {WHOLE}"),
    ("seed=1.5", f"seed=1.5: {WHOLE}"),
    ("seed=x", f"seed=x: {WHOLE}"),
    ("seed=9223372036854775808", f"seed=9223372036854775808: {WHOLE}"),
    ("agent.seed=-1", f"RandomAgent.seed=-1: {WHOLE}"),
    ("pictures=x", f"pictures=x: {WHOLE}"),
    ("pictures=-1", f"pictures=-1: {WHOLE}"),
    ("episodes=-1", f"episodes=-1: {TEXT}"),
    ("episodes=[]", f"episodes=[]: {TEXT}"),
    (f"episodes={LONG}", f"{TEXT} of one line, with file names of at most 255 bytes"),
    ("progress=7", f"progress=7: {SWITCH}"),
    ("batch=x", "batch=x: expected a whole number from 1 up"),
    ("batch=true", "batch=True: expected a whole number from 1 up"),
    ("limit=0", "limit=0: expected a whole number from 1 up or null"),
    ("every=0", "every=0: expected a whole number from 1 up"),
    ("out=''", "out=: expected the path of a folder"),
    ("worker_timeout_s=0", "worker_timeout_s=0: expected seconds above 0 or null"),
    ("workers=x", f"workers=x: {WHOLE} or auto"),
    ("knowledge_base=x", "unknown knowledge base mode"),
    ("habit_level.top_p=0", "habit_level.top_p=0: expected a whole number from 1 up"),
    ("agent=null", "Config group override must be a string"),
    ("detector=3", "Config group override must be a string"),
    ("++env.source=3", "env.source=3: expected a part"),
    ("+nonsense=3", "unknown option 'nonsense'"),
    ("+task.nonsense=3", "unknown option 'task.nonsense'"),
    ("env.privileged=no", f"UcONEnv.privileged=no: {SWITCH}"),
]
OF_TRAIN = [
    ("seed=-1", f"seed=-1: {WHOLE}"),
    ("progress=x", f"progress=x: {SWITCH}"),
    ("tensorboard=no", f"tensorboard=no: {SWITCH}"),
    ("training=3", "training"),
    ("training.keep=x", "training.keep=x: expected a whole number from 1 up"),
    ("learner.own=no", "unknown option 'learner.own'"),
    (f"learner.initial={LONG}", "file names of at most 255 bytes"),
]


def unwritable(tmp_path: Path) -> list[str]:
    """Values of ``out=`` at which no folder can be made."""
    (tmp_path / "file").write_text("")
    (tmp_path / "locked").mkdir()
    (tmp_path / "locked").chmod(0o500)
    found = [f"{tmp_path}/file", f"{tmp_path}/file/below", f"{tmp_path}/{LONG}", "/proc/none/run"]
    if os.access("/sys", os.F_OK):
        found.append("/sys/run")  # a file system that takes no files, even from root
    if os.geteuid():  # nothing is locked for root
        found.append(f"{tmp_path}/locked/run")
    return found


def test_eval_refuses_what_cannot_be(tmp_path: Path) -> None:
    calls = [("eval.py", *QUICK, f"out={tmp_path}/run", word) for word, _ in OF_EVAL]
    policy = ("eval.py", *QUICK[1:], "agent=habit_policy", f"agent.checkpoint={LONG}", f"out={tmp_path}/run")
    habits = ("eval.py", *QUICK, "habits=folder", f"habits.path={LONG}", f"out={tmp_path}/run")
    told = [part for _, part in OF_EVAL] + ["HabitPolicyAgent.checkpoint=aaa", "folder_habits.path=aaa"]
    _each_is_told([*calls, policy, habits], told)
    assert not (tmp_path / "run").exists(), "nothing was played"


def test_train_refuses_what_cannot_be(tmp_path: Path) -> None:
    small = ("learner=belief", "progress=false", "training.steps=1", f"out={tmp_path}/run")
    calls = [("train.py", *small, word) for word, _ in OF_TRAIN]
    _each_is_told([*calls, ("train.py", f"resume={LONG}")], [*(part for _, part in OF_TRAIN), "no run there"])
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    paths = unwritable(tmp_path)
    calls = [("eval.py", *QUICK, f"out={path}") for path in paths]
    calls += [("eval.py", "-m", *QUICK, f"out={path}") for path in paths[:2]]
    calls += [
        ("train.py", "learner=retriever", "training.steps=1", "progress=false", f"out={path}") for path in paths[:2]
    ]
    calls += [("eval.py", *QUICK, f"out={odd}") for odd in ("null", "[1]")]
    _each_is_told(calls, ["" for _ in calls])


def _each_is_told(calls: list[tuple[str, ...]], parts: list[str]) -> None:
    for call, part, (code, told) in zip(calls, parts, outcomes(calls), strict=True):
        assert code == 2, (call, told[-1500:])
        assert told.startswith("error: "), (call, told)
        assert told.count("\n") == 1, (call, told)
        assert part in told, call


@pytest.mark.parametrize("script", ["eval.py", "train.py"])
def test_without_the_environment(script: str, tmp_path: Path) -> None:
    """A Python without any packages, like a system's own."""
    bare = [sys.executable, "-S", str(ROOT / script)]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(bare, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (2, f"error: the module hydra is not installed in this Python; {HOW}\n")


def test_what_is_missing_is_told() -> None:
    assert problem((3, 10)) is None
    assert problem((3, 9, 7)) == (f"Python 3.9 is too old, expected 3.10 or newer; {HOW}")
    assert "the module no_such is not installed" in str(problem((3, 11), ("sys", "no_such")))
