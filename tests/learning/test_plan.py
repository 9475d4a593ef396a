"""The length of a run, and its extensions."""

import pytest

from ucon.core.errors import ConfigError
from ucon.learning.run.run_plan import MOST_STEPS, Extension, Plan

PLAN = Plan(23, validate_every=5, save_every=3)


def test_an_extended_plan_is_as_long_as_its_last_extension():
    longer = PLAN.extend(23, 40)
    assert longer.extended == (Extension(23, 40),)
    assert (PLAN.length, longer.length) == (23, 40)
    assert [longer.length_at(step) for step in (0, 22, 23, 39)] == [23, 23, 40, 40]
    assert [longer.followed(step) for step in (23, 24)] == [(), longer.extended]


def test_validation_stays_where_the_run_had_ended_and_only_there():
    ended, stopped = PLAN.extend(23, 40), PLAN.extend(12, 40)
    assert [step for step in range(41) if ended.validates(step)] == [0, 5, 10, 15, 20, 23, 25, 30, 35, 40]
    assert [step for step in range(41) if stopped.validates(step)] == [0, 5, 10, 15, 20, 25, 30, 35, 40]
    assert [step for step in range(20, 31) if ended.saves(step)] == [20, 21, 23, 24, 25, 27, 30]


def test_extensions_follow_each_other_or_replace_those_that_were_decided_later():
    twice = PLAN.extend(23, 40).extend(30, 50)
    assert twice.extended == (Extension(23, 40), Extension(30, 50))
    assert twice.extend(23, 60).extended == (Extension(23, 60),), "the run went back to its first end"
    assert twice.extend(10, 30).extended == (Extension(10, 30),)
    assert twice.extend(35, 50) is twice, "a repeated command goes on"


@pytest.mark.parametrize(
    ("step", "steps", "message"),
    [
        (23, 23, "steps=23: 23 steps are done; give more, or leave it out"),
        (23, 10, "steps=10: 23 steps are done"),
        (12, 20, "steps=20: the run already has 23; give more, or leave it out"),
        (12, MOST_STEPS + 1, "does not follow"),
    ],
)
def test_no_fewer_steps(step, steps, message):
    with pytest.raises(ConfigError, match=message):
        PLAN.extend(step, steps)


@pytest.mark.parametrize(
    "extended",
    [
        7, "x", {"at": 1, "steps": 40}, [3], [{"at": 23}], [{"at": 23, "steps": 40, "more": 1}],
        [{"at": "23", "steps": 40}], [{"at": True, "steps": 40}], [{"at": -1, "steps": 40}], [{"at": 24, "steps": 40}],
        [{"at": 20, "steps": 23}], [{"at": 20, "steps": 30}, {"at": 20, "steps": 40}], [{"at": 5, "steps": 10**30}],
        [{"at": 20, "steps": float("nan")}],
    ],
)  # fmt: skip
def test_what_is_no_extension_is_refused_in_a_line(extended):
    with pytest.raises(ConfigError, match=r"training\.extended") as caught:
        Plan.of({"steps": 23, "extended": extended})
    assert "\n" not in str(caught.value)


def test_a_configuration_holds_extensions():
    longer = PLAN.extend(23, 40)
    options = {"steps": 23, "validate_every": 5, "save_every": 3, "extended": [e.to_json() for e in longer.extended]}
    assert Plan.of(options) == longer
