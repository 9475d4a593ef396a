"""Evaluation on two raylets: the records equal those of one process, whichever worker or machine is lost."""

from functools import partial

import pytest

pytest.importorskip("ray")

from models.agents.random import RandomAgent
from tests.cluster.agents import Befalls, Slow
from tests.cluster.raylets import two_raylets, wait_until_ended
from ucon.cluster.runner import RayRunner
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.playing.crew import WorkerError
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")[:8]


def spec(agent, **options) -> RunSpec:
    return RunSpec(agent, partial(UcONEnv, EPISODES[:1], habit_level="none", observe="symbolic"), "none", **options)


def lines(played) -> str:
    return to_lines(one.record for one in played)


@pytest.fixture(scope="module")
def alone() -> str:
    return lines(evaluate(spec(partial(RandomAgent, seed=4, done_probability=0.05)), EPISODES, workers=0))


@pytest.fixture(scope="module")
def cluster():
    with two_raylets() as made:
        yield RayRunner(made.address)


def played_on(runner, agent, *, count=8, workers=2, timeout_s=None, **options):
    found = []
    evaluate(
        spec(agent, **options),
        EPISODES[:count],
        workers=workers,
        worker_timeout_s=timeout_s,
        on_played=found.append,
        runner=runner,
    )
    assert sorted(one.index for one in found) == list(range(count)), "each once"
    return sorted(found, key=lambda one: one.index)


@pytest.mark.parametrize(("what", "batch", "timeout_s"), [("killed", 1, None), ("stopped", 2, 8.0)])
def test_a_worker_that_is_lost_is_replaced_and_named(cluster, alone, tmp_path, capfd, what, batch, timeout_s):
    agent = partial(Befalls, what, tmp_path, EPISODES[3].target_category, 1)
    assert lines(played_on(cluster, agent, batch=batch, timeout_s=timeout_s)) == alone
    (process,) = (int(path.name) for path in tmp_path.iterdir())
    told = capfd.readouterr().err
    assert told.count("warning: worker ") == 1
    assert f"(process {process} on " in told
    assert ("worker_timeout_s" in told and EPISODES[3].id in told) or what == "killed"


def test_what_no_worker_survives_ends_the_run(cluster, tmp_path):
    agent = partial(Befalls, "killed", tmp_path, EPISODES[1].target_category, 9)
    with pytest.raises(WorkerError, match=r"not finished by any of 3 workers; the last one, worker \d+ \(process"):
        played_on(cluster, agent, count=2)
    processes = [int(path.name) for path in tmp_path.iterdir()]
    assert len(processes) == 3
    wait_until_ended(processes)


@pytest.mark.slow
def test_what_stops_every_worker_ends_the_run(cluster, tmp_path):
    agent = partial(Befalls, "stopped", tmp_path, EPISODES[0].target_category, 9)
    with pytest.raises(EpisodeError, match=r"not finished by any of 3 workers; .* within 4 s \(worker_timeout_s\)"):
        played_on(cluster, agent, count=1, timeout_s=4.0)


@pytest.mark.parametrize(
    ("what", "error", "said"),
    [("refuses", ConfigError, "^agent.option=7: expected another$"), ("fails", WorkerError, "it is broken")],
)
def test_errors_of_workers_are_told(cluster, tmp_path, what, error, said):
    with pytest.raises(error, match=said):
        played_on(cluster, partial(Befalls, what, tmp_path, EPISODES[0].target_category, 9), count=2)


def test_no_workers_are_refused():
    with pytest.raises(ConfigError, match="workers=0: with runner=ray expected"):
        played_on(RayRunner(), RandomAgent, workers=0)


def test_a_raylet_that_is_killed_costs_nothing(alone, capfd):
    """Both workers play; one raylet dies with its worker, and afterwards there is room for only one."""
    with two_raylets() as made:
        kept = []

        def on_played(one):
            kept.append(one)
            if len(kept) == 2:
                made.wait_until_full()
                made.kill_second()

        runner = RayRunner(made.address)
        found = evaluate(spec(Slow), EPISODES, workers=2, on_played=on_played, runner=runner)
    assert sorted(one.index for one in kept) == list(range(len(EPISODES)))
    assert lines(found) == alone
    assert "warning: worker " in capfd.readouterr().err
