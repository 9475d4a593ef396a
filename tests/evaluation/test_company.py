"""Workers and other episodes in the same process do not change searchers, and failures reach the user."""

import os
from dataclasses import replace
from functools import partial

import pytest

from models.agents.belief import BeliefAgent
from models.agents.frontier import FrontierAgent
from tests.evaluation.random_runs import lines, random_run, six_episodes
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.playing.crew import WorkerError
from ucon.evaluation.playing.runner import evaluate


@pytest.fixture(scope="module")
def episodes():
    return six_episodes()


@pytest.fixture(scope="module")
def spec():
    return random_run()


@pytest.mark.parametrize("agent", [BeliefAgent, FrontierAgent])
def test_searchers_do_not_depend_on_company(spec, episodes, agent):
    env = partial(UcONEnv, episodes[:1], habit_level="retrieval", observe="symbolic", detector=True)
    spec = replace(spec, agent=agent, env=env)
    some = episodes[:4]
    alone = lines([played for k in range(4) for played in evaluate(spec, some[k : k + 1], workers=0)])
    assert lines(evaluate(spec, some[::-1], workers=2)) == alone
    assert lines(evaluate(replace(spec, batch=3), some, workers=0)) == alone


def fails():
    raise ValueError("the agent's own bug")


def complains():
    raise ConfigError("agent: weights missing; train it")


def dies():
    os._exit(7)


@pytest.mark.parametrize(
    ("agent", "error", "message"),
    [
        (fails, WorkerError, r"(?s)failed:.*in fails.*the agent's own bug"),
        (complains, ConfigError, "^agent: weights missing; train it$"),
        (dies, WorkerError, r"died with exit code 7 .*, as did others: 3 workers began"),
    ],
)
def test_failures_of_workers_reach_the_user(spec, episodes, agent, error, message):
    with pytest.raises(error, match=message):
        evaluate(replace(spec, agent=agent), episodes, workers=2)
