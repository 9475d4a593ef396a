"""Twenty episodes whose figures and records are fixed here, so that any change to them is noticed at once.

The agents use no networks, so the bytes are the same on every processor. If a change is intended, update the digest
here together with the tables that change with it.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest

from models.agents.belief import BeliefAgent
from models.agents.frontier import FrontierAgent
from models.agents.oracle import OracleAgent
from models.agents.random import RandomAgent
from ucon.core.files import sha256_bytes
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.task.sets import load_episodes

N = 20
#: Agent, habit level, SR, SPL (six digits) and SHA-256 of the records' lines.
GOLDEN: dict[str, tuple[Any, str, float, float, str]] = {
    "oracle": (OracleAgent, "none", 1.0, 1.0, "211ddd6fbd7b6233687d01f587b1c732037f4a71b761398322ee0205961ecd70"),
    "random": (
        partial(RandomAgent, seed=4, done_probability=0.02), "none", 0.0, 0.0,
        "3706b321fdcd108f3515268804fe9c9bc2f4ed2bdddd4bc32c9486ce906ad237",
    ),
    "frontier": (
        FrontierAgent, "none", 0.6, 0.385048,
        "cd31eaae36fb585a4ce444c358d1c35f150c9d333e805286ad64bad807d82728",
    ),
    "belief": (BeliefAgent, "gt", 0.6, 0.499499, "404d441c0e409b9ea18e60b000135fd8a96507104930a684030a2ac5cedf0091"),
}  # fmt: skip
SEARCHERS = ("frontier", "belief")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SEARCHERS)) for name in GOLDEN]
)
def test_figures_and_records_are_those_written_down(name: str) -> None:
    agent, level, success_rate, spl, digest = GOLDEN[name]
    episodes = load_episodes("mini")[:N]
    env = partial(UcONEnv, episodes[:1], habit_level=level, observe="symbolic", detector=True, privileged=True)
    records = [played.record for played in evaluate(RunSpec(agent, env, level), episodes, workers=0)]
    figures = summarise(records)
    assert len(records) == N
    assert (figures["success_rate"], round(figures["spl"], 6)) == (success_rate, spl)
    assert sha256_bytes(to_lines(records).encode()) == digest
