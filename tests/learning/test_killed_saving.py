"""A process that only saves, killed repeatedly: the checkpoint named by ``latest`` is always whole."""

import multiprocessing
import os
import signal
import time

import pytest

from ucon.core.rng import stream
from ucon.learning.run.checkpoints import LATEST, Checkpoints
from ucon.learning.run.protocol import State

IDENTITY = {"config": "c"}
KILLS = 50
#: Numbers in each of two tensors, 8 MB together, so that most of the time is spent writing.
SIZE = 1_000_000


def state(step: int) -> State:
    """A state with the step in both tensors and in the values, so that a mixture of two saves would be noticed."""
    import torch

    full = {name: torch.full((SIZE,), float(step)) for name in ("first", "second")}
    return State(full, {"step": step})


def save_without_end(folder) -> None:
    checkpoints = Checkpoints(folder, IDENTITY, keep=2)
    step = checkpoints.load()[0] if (folder / LATEST).exists() else 0
    while True:
        step += 1
        checkpoints.save(step, state(step))


def told(folder) -> str:
    """Content of ``latest``; empty before the first save."""
    return (folder / LATEST).read_text() if (folder / LATEST).exists() else ""


def found(folder) -> int:
    """The step of the newest checkpoint, which must be whole and consistent; 0 before the first."""
    if not (folder / LATEST).exists():
        return 0
    step, loaded = Checkpoints(folder, IDENTITY).load()
    assert loaded.values["step"] == step
    assert all(bool((tensor == step).all()) for tensor in loaded.tensors.values())
    return step


@pytest.mark.slow
def test_no_kill_leaves_an_unreadable_checkpoint(tmp_path):
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["torch", "safetensors.torch", "ucon.learning.run.checkpoints"])
    folder, draw, steps, halves = tmp_path / "checkpoints", stream(0, "kill", "saving"), [0], 0
    for _ in range(KILLS):
        process, before = context.Process(target=save_without_end, args=(folder,)), told(folder)
        process.start()
        while process.is_alive() and told(folder) == before:  # until it has saved once
            time.sleep(0.002)
        time.sleep(float(draw.uniform(0, 0.1)))
        assert process.is_alive(), "it saves until it is killed"
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        steps.append(found(folder))
        halves += any(folder.glob(".*"))
    assert steps == sorted(set(steps)), "each one went on from where the one before was killed"
    assert halves > KILLS // 3, "most kills were not within a save"
    Checkpoints(folder, IDENTITY, keep=2).save(steps[-1] + 1, state(steps[-1] + 1))
    assert not list(folder.glob(".step_*")), "what the killed ones left half is swept"
    assert len(Checkpoints(folder, IDENTITY).all()) == 2
