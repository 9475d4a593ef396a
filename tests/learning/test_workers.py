"""Workers compute with one thread each, whatever their environment says, and none is waited for forever."""

import functools
import multiprocessing
import os
import signal
import threading
import time

import pytest
import torch

from tests.learning.tiny_policy import TinyPolicy, tiny_imitation, training_file
from tests.learning.tiny_ppo import tiny_ppo
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.trajectories import demonstration
from ucon.learning.ppo.collecting import InWorkers
from ucon.learning.run import workers as workers_module
from ucon.learning.run.workers import LearnerWorkerError, ask, begin_worker
from ucon.task.sets import load_episodes


@pytest.fixture(autouse=True)
def three_threads(monkeypatch):
    """The number of threads that a worker would otherwise use."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(name, "3")


def count(pipe):
    torch.set_num_threads(3)
    begin_worker()
    pipe.send(torch.get_num_threads())


@pytest.mark.slow
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
    """A policy whose frames show the number of threads."""

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


@pytest.mark.slow
def test_those_who_gather_experience_have_one(tmp_path):
    learner = tiny_ppo(tmp_path, Counting(), collector=InWorkers(2), frames=8, levels=("none",))
    try:
        batch = learner.rollouts.collect(1)
    finally:
        learner.close()
    assert {int(tensor.max()) for tensor in batch["frames"].values()} == {1}


SLOW = pytest.mark.slow  # workers take seconds to start


def stop(processes, number):
    """Send a signal to the first of some processes, and return its id."""
    first = next(iter(processes))
    os.kill(first.pid, number)
    return first.pid


@SLOW
@pytest.mark.parametrize(
    ("number", "message"),
    [
        (
            signal.SIGSTOP,
            r"\(process {pid}\): no answer within 3 s, .*resume=RUN continues, collector.worker_timeout_s",
        ),
        (signal.SIGKILL, r"\(process {pid}\): killed by signal 9, .*resume=RUN continues"),
    ],
)
def test_who_gathers_experience_is_not_waited_for_for_ever(monkeypatch, tmp_path, number, message):
    monkeypatch.setattr(workers_module, "MOST_REPLACED", 0)
    learner = tiny_ppo(tmp_path, collector=InWorkers(2, worker_timeout_s=120.0), frames=8, levels=("none",))
    try:
        learner.step()
        object.__setattr__(learner.rollouts._collecting, "worker_timeout_s", 3.0)
        pid = stop(learner.rollouts._workers(), number)
        with pytest.raises(LearnerWorkerError, match=message.format(pid=pid)) as caught:
            learner.step()
        assert "\n" not in str(caught.value)
        assert str(caught.value).count("(process") == 1, "the other one answers"
    finally:
        learner.close()
    assert learner.done == 1


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (signal.SIGSTOP, r"\(process {pid}\): no answer within 3 s, .*resume=RUN continues, learner.worker_timeout_s"),
        pytest.param(signal.SIGKILL, r"\(process {pid}\): killed by signal 9, .*resume=RUN continues", marks=SLOW),
    ],
)
def test_who_plays_ahead_of_learning_is_not_waited_for_for_ever(monkeypatch, tmp_path, number, message):
    monkeypatch.setattr(workers_module, "MOST_REPLACED", 0)
    learner = tiny_imitation(tmp_path, workers=1, worker_timeout_s=120.0, memory_gb=0.0)
    try:
        learner.step()
        learner.feeder._timeout_s = 3.0
        pid = stop(learner.feeder._workers(), number)
        with pytest.raises(LearnerWorkerError, match=message.format(pid=pid)) as caught:
            all(learner.step() for _ in range(8))  # results that were made ahead are used first
        assert "\n" not in str(caught.value)
    finally:
        learner.close()


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL, signal.SIGCONT])
def test_who_does_not_answer_is_named_and_ended(monkeypatch, number):
    """Of two sleeping workers: the stopped one, the killed one, or both if they merely take too long."""
    context = multiprocessing.get_context("fork")  # which does not run our start-up code
    workers = [context.Process(target=time.sleep, args=(600,), daemon=True) for _ in range(2)]
    for worker in workers:
        worker.start()
    pid = stop(workers, number)
    try:
        monkeypatch.setattr(workers_module, "_GRACE_S", 0.5)
        with pytest.raises(LearnerWorkerError, match=rf"\(process {pid}\).*resume=RUN continues") as caught:
            wait_for(workers)
        named = sum(f"(process {worker.pid})" in str(caught.value) for worker in workers)
        assert named == (2 if number == signal.SIGCONT else 1)
    finally:
        for worker in workers:
            worker.kill()
            worker.join()


def wait_for(workers):
    """Wait for an answer that never comes, as those who hand out work do."""
    ask(threading.Event().wait, 3.0, lambda: workers, "x")


def test_what_a_worker_raises_is_not_hidden():
    def wrong():
        raise KeyError

    for crew in ([], [multiprocessing.current_process()]):
        with pytest.raises(KeyError):
            ask(wrong, 10.0, lambda crew=crew: crew, "x")
        assert ask(lambda: 7, 10.0, lambda crew=crew: crew, "x") == 7


@pytest.mark.parametrize("value", [0, -1, "x", True, None, float("nan"), float("inf"), 1e9])
def test_impossible_limits(tmp_path, value):
    with pytest.raises(ConfigError, match=r"collector\.worker_timeout_s=.*expected seconds, above 0"):
        InWorkers(2, worker_timeout_s=value)
    with pytest.raises(ConfigError, match=r"learner\.worker_timeout_s=.*expected seconds, above 0"):
        tiny_imitation(tmp_path, worker_timeout_s=value)
