"""Training runs with workers that are really killed or stopped: they are replaced, and the bytes stay the same."""

import contextlib
import os
import signal
import time

import pytest

from tests.learning.test_imitation import files
from tests.learning.tiny_policy import TinyPolicy, tiny_dagger, tiny_imitation, training_file
from tests.learning.tiny_ppo import tiny_ppo
from ucon.learning.ppo.collecting import InWorkers
from ucon.learning.run.training_run import Plan, TrainingRun
from ucon.learning.run.workers import MOST_REPLACED, LearnerWorkerError, Replacements

STEPS = 4
PLAN = Plan(steps=STEPS, validate_every=4, save_every=2)
#: Seconds within which a dead worker has to be noticed.
NOTICED_S = 10.0
#: Limit for workers that hang, in seconds.
PATIENCE_S = 4.0
pytestmark = [
    pytest.mark.slow,  # workers take seconds to start
    pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no signals that stop a process"),
]


def imitation(episodes, workers=1):
    options = {"memory_gb": 0.0, "workers": workers, "steps": STEPS}
    return tiny_imitation(None, TinyPolicy(dropout=0.2), episodes=episodes, **options)


def dagger(episodes, workers=1):
    few = {"per_iteration": 2, "episodes": 3, "max_steps": 12}
    options = {"memory_gb": 0.0, "workers": workers, "steps": STEPS}
    return tiny_dagger(None, TinyPolicy(dropout=0.2), few, episodes=episodes, **options)


def ppo(episodes, workers=2):
    collector = InWorkers(2)
    return tiny_ppo(None, episodes=episodes, collector=collector, frames=16, levels=("none",), steps=STEPS)


def crew_of(learner):
    return learner.rollouts if hasattr(learner, "rollouts") and hasattr(learner.rollouts, "collect") else learner.feeder


@pytest.fixture(scope="module")
def episodes(tmp_path_factory):
    return training_file(tmp_path_factory.mktemp("episodes"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory, episodes):
    """Files of a run without losses; its results do not depend on the number of workers."""
    made = {}

    def of(make):
        if make not in made:
            folder = tmp_path_factory.mktemp("whole") / make.__name__
            train(make(episodes, workers=0), folder)
            made[make] = files(folder)
        return made[make]

    return of


def train(learner, folder, after=lambda step: None):
    run = TrainingRun(folder, learner, PLAN, {})
    try:
        run.start("a: 1\n")
        run.run(lambda step, figures: after(step) if "loss" in figures else None)
    finally:
        learner.close()


def losing(learner, number, told, steps):
    """After each of ``steps``, send the first worker a signal, and note its process and the time in ``told``."""

    def after(step):
        crew = crew_of(learner)
        if step in steps:
            if number == signal.SIGSTOP:
                be_impatient(crew)
            worker = crew._workers()[0]
            told.append((worker.pid, time.monotonic()))
            os.kill(worker.pid, number)

    return after


def be_impatient(crew):
    if hasattr(crew, "_timeout_s"):
        crew._timeout_s = PATIENCE_S
    else:
        object.__setattr__(crew._collecting, "worker_timeout_s", PATIENCE_S)


def be_patient(crew):
    """Allow time, since new workers need it to start."""
    if hasattr(crew, "_timeout_s"):
        crew._timeout_s = 120.0
    else:
        object.__setattr__(crew._collecting, "worker_timeout_s", 120.0)


@pytest.mark.parametrize(
    ("make", "number"),
    [
        (imitation, signal.SIGKILL),
        (imitation, signal.SIGSTOP),
        (dagger, signal.SIGKILL),
        (dagger, signal.SIGSTOP),
        (ppo, signal.SIGKILL),
        (ppo, signal.SIGSTOP),
    ],
)
def test_a_worker_that_is_lost_is_replaced_and_the_bytes_are_the_same(
    monkeypatch, tmp_path, episodes, whole, capfd, make, number
):
    learner, lost, noticed = make(episodes), [], []
    count = Replacements.count

    def counted(self, error):
        noticed.append(time.monotonic())
        be_patient(crew_of(learner))
        count(self, error)

    monkeypatch.setattr(Replacements, "count", counted)
    be_patient(crew_of(learner))
    train(learner, tmp_path / "run", losing(learner, number, lost, {1}))
    ((pid, at),) = lost
    assert len(noticed) == 1
    assert noticed[0] - at < NOTICED_S, "of a stopped one: the limit that was set, and a look at who is stopped"
    told = [line for line in capfd.readouterr().err.splitlines() if line.startswith("warning: worker ")]
    assert len(told) == 1
    assert f"(process {pid}): {'killed by signal 9' if number == signal.SIGKILL else 'no answer within 4 s'}" in told[0]
    assert "the workers are replaced (1 of at most 3 times), and their unfinished work is done again" in told[0]
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    ours, theirs = files(tmp_path / "run"), whole(make)
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []


@pytest.mark.parametrize("make", [imitation, ppo])
def test_workers_that_are_lost_again_and_again_end_the_run_in_one_line(tmp_path, episodes, make):
    learner, lost = make(episodes), []
    try:
        with pytest.raises(LearnerWorkerError) as caught:
            all(step_and_lose(learner, lost) for _ in range(6 * MOST_REPLACED))  # played ahead
    finally:
        learner.close()
    assert f"(process {lost[-1][0]}): killed by signal 9" in str(caught.value)
    assert str(caught.value).endswith("replaced 3 times; what is saved is kept: resume=RUN continues")
    assert "\n" not in str(caught.value)


def step_and_lose(learner, lost):
    learner.step()
    with contextlib.suppress(ProcessLookupError):  # its loss may not have been noticed yet
        losing(learner, signal.SIGKILL, lost, {1})(1)
    return True
