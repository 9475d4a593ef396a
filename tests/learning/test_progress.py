"""Logging to Weights & Biases: offline into the run's folder, and without ever disturbing training.

Each run has a process of its own: wandb reads its environment once.
"""

import os
import pty
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests.learning.tiny_policy import tiny_dagger
from tests.learning.tiny_ppo import tiny_ppo
from ucon.core.errors import ConfigError
from ucon.learning.run import run_progress as progress
from ucon.learning.run.run_progress import wandb_log

ROOT = Path(__file__).parents[2]
#: Trains the smallest learner in the given folder, and logs it.
TRAIN = """
import sys
from pathlib import Path
from tests.learning.tiny import Line
from ucon.learning.run import run_progress as progress
from ucon.learning.run.training_run import Plan, TrainingRun

progress.WANDB_PATIENCE_S = 3
mode, folder = sys.argv[1], Path(sys.argv[2])
run = TrainingRun(folder, Line(), Plan(steps=4), {})
run.start("a: 1")
with progress.wandb_log(mode, folder, {"a": 1}) as log:
    run.run(log)
"""
LIMIT_S = 120


def train(mode, home, run, *, at_a_terminal=False, **env):
    """Train with wandb in ``mode``; returns its standard error (all output at a terminal), and the seconds."""
    of_wandb = {name for name in os.environ if name.startswith("WANDB_")}
    kept = {name: value for name, value in os.environ.items() if name not in of_wandb | {"NETRC"}}
    kept |= {"HOME": str(home), "PYTHONPATH": str(ROOT), **env}
    command, began = [sys.executable, "-c", TRAIN, mode, str(run)], time.monotonic()
    ours, theirs = pty.openpty() if at_a_terminal else (None, subprocess.PIPE)
    streams = {"stdin": theirs if at_a_terminal else subprocess.DEVNULL, "stdout": theirs, "stderr": theirs}
    try:
        done = subprocess.run(command, cwd=ROOT, env=kept, timeout=LIMIT_S, check=False, **streams)
        told = os.read(ours, 1 << 16).decode() if at_a_terminal else done.stderr.decode()
    finally:
        if at_a_terminal:
            os.close(ours)
            os.close(theirs)
    assert done.returncode == 0, told
    assert (run / "summary.json").is_file()
    return told, time.monotonic() - began


def offline_logs(run):
    return list((run / "wandb").glob("offline-run-*/run-*.wandb"))


def test_offline_writes_a_run_into_the_folder(tmp_path):
    told, _ = train("offline", tmp_path, tmp_path / "run")
    (log,) = offline_logs(tmp_path / "run")
    assert log.stat().st_size > 500
    assert b"val/score" in log.read_bytes()
    assert "warning" not in told


@pytest.mark.slow
def test_online_without_a_network_goes_on_offline(tmp_path):
    dead = {"WANDB_BASE_URL": "http://127.0.0.1:9", "WANDB_API_KEY": "a" * 40}
    told, seconds = train("online", tmp_path, tmp_path / "run", **dead)
    (log,) = offline_logs(tmp_path / "run")
    assert b"val/score" in log.read_bytes()
    (warning,) = [line for line in told.splitlines() if "warning" in line]
    assert warning.startswith("warning: wandb=online: ")
    assert f"logging offline to {tmp_path}/run/wandb" in warning
    assert seconds < LIMIT_S / 2


@pytest.mark.slow
def test_online_at_a_terminal_asks_for_no_key(tmp_path):
    told, seconds = train("online", tmp_path, tmp_path / "run", at_a_terminal=True)
    assert "warning: wandb=online: nobody is logged in" in told
    assert "Enter your choice" not in told
    assert offline_logs(tmp_path / "run")
    assert seconds < LIMIT_S / 2


def test_an_upload_that_takes_too_long_ends_in_a_warning(tmp_path, capsys):
    class Slow:
        def finish(self):
            raise TimeoutError

    progress._finish(Slow(), tmp_path)
    assert "`wandb sync` sends what is in" in capsys.readouterr().err


def refusal(mode, folder):
    with pytest.raises(ConfigError) as caught, wandb_log(mode, folder, {}):
        pytest.fail("it was not refused")
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("mode", ["onlin", True, "disabled"])
def test_unknown_modes_are_refused(tmp_path, mode):
    said = refusal(mode, tmp_path)
    assert f"unknown wandb mode '{mode}'" in said
    assert "online" in said
    assert not list(tmp_path.iterdir())


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "wandb", None)
    assert refusal("offline", tmp_path) == (
        "wandb=offline: the package is not installed; `pip install wandb` or wandb=false"
    )


@pytest.mark.parametrize("mode", [False, None])
def test_nothing_is_imported_unless_asked_for(tmp_path, mode, monkeypatch):
    monkeypatch.setitem(sys.modules, "wandb", None)
    with wandb_log(mode, tmp_path, {}) as log:
        log(1, {"loss": 1.0})
    assert not list(tmp_path.iterdir())


def test_a_run_that_goes_on_shows_its_best_validation(capsys):
    with progress.training_progress("x", 10, 4, best=-1.25):
        pass
    with progress.training_progress("x", 10):
        pass
    assert capsys.readouterr().err == "x: 4 of 10 steps, loss - val -1.250\nx: 0 of 10 steps, loss - val -\n"


@pytest.mark.parametrize("name", ["ppo", "dagger"])
def test_a_long_step_says_what_it_is_at(name, tmp_path, monkeypatch, capsys):
    """Progress lines are written without any delay between them."""
    monkeypatch.setattr("ucon.core.progress.MOST_S", 0.0)
    learner = tiny_ppo(tmp_path) if name == "ppo" else tiny_dagger(tmp_path)
    with closing(learner), progress.training_progress(name, 1) as show:
        show(1, learner.step())
        learner.validate()
    told = capsys.readouterr().err
    wanted = {"ppo": ("collecting", "updating 1 of ", "validating 2 of 2")}
    wanted["dagger"] = ("collecting 4 of 4", "validating demonstrations 1 of ", "validating 2 of 2")
    assert [word for word in wanted[name] if f"{name}: " not in told or word not in told] == []
