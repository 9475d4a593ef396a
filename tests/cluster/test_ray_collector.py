"""Training on two raylets: the experience equals that of local workers, whichever worker or machine is lost."""

import os
import signal
from contextlib import closing

import pytest
import torch

pytest.importorskip("ray")

from tests.cluster.raylets import two_raylets
from tests.learning.tiny_policy import ENV, TinyPolicy
from tests.learning.tiny_ppo import LEVELS, tiny_ppo
from ucon.cluster.collecting import OnRay
from ucon.core.errors import ConfigError
from ucon.learning.ppo.collecting import ExperienceCollector, InWorkers
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun
from ucon.learning.run.workers import LearnerWorkerError
from ucon.task.sets import load_episodes

SEEDS = (3, 4, 5)


def collector(collecting):
    return ExperienceCollector(TinyPolicy(), ENV, load_episodes("mini")[:4], LEVELS, collecting, 20)


def equal(one, other):
    return all(torch.equal(one[key], other[key]) for key in one.keys(True, True) if "traj_ids" not in key)


@pytest.fixture(scope="module")
def here():
    """Collections of two local workers."""
    made = collector(InWorkers(2))
    yield [made.collect(seed).clone() for seed in SEEDS]
    made.close()


@pytest.fixture(scope="module")
def address():
    with two_raylets(2) as made:
        yield made.address


def processes(made):
    """Process numbers of a collector's workers."""
    import ray

    asked = [
        worker.__ray_call__.remote(lambda self: os.getpid()) for worker in made._collector._collector.remote_collectors
    ]
    return ray.get(asked)


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (signal.SIGKILL, "a worker died"),
        pytest.param(signal.SIGSTOP, "worker 1 did not answer within 5 s", marks=pytest.mark.slow),
    ],
)
def test_a_lost_worker_is_replaced_and_changes_no_experience(here, address, capfd, number, said):
    made = collector(OnRay(2, address, worker_timeout_s=5.0 if number == signal.SIGSTOP else 3600.0))
    assert equal(made.collect(SEEDS[0]), here[0])
    before = processes(made)
    os.kill(before[1], number)
    assert equal(made.collect(SEEDS[1]), here[1])
    assert equal(made.collect(SEEDS[2]), here[2])
    assert not set(before) & set(processes(made))
    made.close()
    assert said in capfd.readouterr().err


@pytest.mark.slow
def test_workers_that_never_answer_end_the_run(address, monkeypatch):
    made = collector(OnRay(2, address, worker_timeout_s=0.01))
    monkeypatch.setattr("ucon.cluster.collecting._PING_S", 0.1)
    with pytest.raises(LearnerWorkerError, match=r"did not answer within 0\.01 s, 3 times in a row.*resume=RUN"):
        made.collect(1)
    made.close()


@pytest.mark.slow
def test_training_goes_on_where_a_raylet_is_killed(tmp_path, capfd):
    def trained(folder, collecting, on_figures=lambda step, figures: None):
        plan = Plan(steps=4, validate_every=4, save_every=2, keep=1)
        with closing(tiny_ppo(folder, collector=collecting)) as learner:
            run = TrainingRun(folder, learner, plan, {})
            run.start("a: 1\n")
            run.run(on_figures)
        files = sorted(path for path in folder.rglob("*") if path.suffix == ".safetensors" or path.name == METRICS)
        return {path.relative_to(folder): path.read_bytes() for path in files}

    for name in ("here", "there"):
        (tmp_path / name).mkdir()
    with two_raylets(2) as made:

        def kill(step, figures):
            if step == 2:
                made.kill_second()

        there = trained(tmp_path / "there", OnRay(2, made.address), kill)
    assert there == trained(tmp_path / "here", InWorkers(2))
    assert len(there) > 2


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2", True])
def test_no_workers_are_refused(workers):
    with pytest.raises(ConfigError, match=r"collector\.workers=.*expected a whole number from 1"):
        OnRay(workers)
