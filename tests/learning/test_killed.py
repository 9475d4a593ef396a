"""Runs that are killed repeatedly at random times end in the same bytes as an undisturbed one."""

import multiprocessing
import os
import signal
import time

import pytest

from tests.learning.test_imitation import files
from tests.learning.tiny_policy import TinyPolicy, tiny_dagger, tiny_imitation, training_file
from tests.learning.tiny_ppo import tiny_ppo
from ucon.core.rng import stream
from ucon.learning.run.checkpoints import LATEST
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun

STEPS = 24
MADE = {"imitation": tiny_imitation, "dagger": tiny_dagger, "ppo": tiny_ppo}


def train(kind, episodes, folder):
    """Start the run, or continue where the last process stopped; runs in each process."""
    import torch

    torch.set_num_threads(1)
    made = MADE[kind](None, TinyPolicy(dropout=0.2), episodes=episodes, steps=STEPS, average=0.8)
    run = TrainingRun(folder, made, Plan(steps=STEPS, validate_every=5, save_every=2, keep=2), {})
    if (run.checkpoints.folder / LATEST).exists():
        run.resume()
    else:
        run.start("a: 1\n")
    run.run()


def lines(folder):
    return (folder / METRICS).read_text().count("\n") if (folder / METRICS).is_file() else 0


def killed(start, folder, draw):
    """Kill a process at a random time some lines of metrics after its start; False if it had already finished."""
    process, until = start(folder), lines(folder) + int(draw.integers(0, 3))
    while process.is_alive() and lines(folder) < until:
        time.sleep(0.002)
    time.sleep(float(draw.uniform(0, 0.1)))
    if process.is_alive():
        os.kill(process.pid, signal.SIGKILL)
    process.join()
    return process.exitcode == -signal.SIGKILL


def visible(folder):
    """Files without those under temporary names, which a killed process may leave behind."""
    return {name: content for name, content in files(folder).items() if not name.rpartition("/")[2].startswith(".")}


@pytest.mark.parametrize(
    ("kind", "kills"),
    [
        pytest.param("imitation", 20, marks=pytest.mark.slow),
        pytest.param("dagger", 20, marks=pytest.mark.slow),
        pytest.param("ppo", 20, marks=pytest.mark.slow),
    ],
)
def test_a_run_that_is_killed_at_random_ends_in_the_same_bytes(tmp_path, kind, kills):
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.learning.tiny_ppo", "ucon.learning.run.training_run", "torch._dynamo"])
    episodes = training_file(tmp_path)

    def start(folder):
        process = context.Process(target=train, args=(kind, episodes, folder))
        process.start()
        return process

    whole, parts = tmp_path / "whole", tmp_path / "parts"
    start(whole).join()
    draw = stream(kills, "kill", kind)
    done = sum(killed(start, parts, draw) for _ in range(kills))
    start(parts).join()
    assert done >= max(1, kills * 2 // 3), "most of them were finished before they could be killed"
    ours, theirs = visible(parts), visible(whole)
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []
