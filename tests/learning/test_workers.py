"""Workers compute with one thread each, whatever their environment says."""

import functools
import multiprocessing

import pytest
import torch

from tests.learning.tiny_policy import TinyPolicy, training_file
from tests.learning.tiny_ppo import tiny_ppo
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.collecting import InWorkers
from ucon.learning.feeding import Feeder
from ucon.learning.trajectories import demonstration
from ucon.learning.workers import begin_worker
from ucon.task.sets import load_episodes


@pytest.fixture(autouse=True)
def three_threads(monkeypatch):
    """What a worker would compute with, did it not choose, on a machine that has as many."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(name, "3")


def count(pipe):
    torch.set_num_threads(3)
    begin_worker()
    pipe.send(torch.get_num_threads())


def test_a_worker_begins_with_one_thread():
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    worker = context.Process(target=count, args=(theirs,))
    worker.start()
    assert ours.poll(600)
    assert ours.recv() == 1
    worker.join(60)
    assert worker.exitcode == 0


class Counting(TinyPolicy):
    """Shows the number of threads in place of what is seen; knows of no other."""

    def frame(self, observation, info):
        shown = super().frame(observation, info)
        return {name: array * 0 + torch.get_num_threads() for name, array in shown.items()}


def test_those_who_play_ahead_of_learning_have_one(tmp_path):
    env = functools.partial(UcONEnv, "mini", observe="pixels")
    shown = [demonstration(load_episodes(training_file(tmp_path))[0], "none")]
    feeder = Feeder(Counting(), env, workers=1)
    try:
        ((_, replay),) = next(iter(feeder([shown])))
    finally:
        feeder.close()
    assert {int(array.max()) for array in replay.frames.values()} == {1}


def test_those_who_gather_experience_have_one(tmp_path):
    learner = tiny_ppo(tmp_path, Counting(), collector=InWorkers(2), frames=8, levels=("none",))
    try:
        batch = learner.rollouts.collect(1)
    finally:
        learner.close()
    assert {int(tensor.max()) for tensor in batch["frames"].values()} == {1}
