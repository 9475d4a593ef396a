"""Why a search failed, in one line, for every cause."""

from __future__ import annotations

from typing import get_args

import pytest

from tests.evaluation.records import record
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.endings import why_lost
from ucon.task.outcome import FailureCause

DECISIONS = [DecisionRecord("e0", 0, 12, "landmark", ("look at: laptop 53 (beside)",), 0)]
LINES = {
    "never_seen": "never seen; steps ran out at 300",
    "seen_not_reached": "seen first at step 20, but not approached; steps ran out at 300",
    "container_never_opened": "the container that holds it was never opened; steps ran out at 300",
    "stopped_early": "Done was said elsewhere at step 300 (look at: laptop 53 (beside)); seen first at step 20",
    "out_of_steps": "in view and within reach, but Done was not said there; steps ran out at 300",
}


def test_every_cause_has_a_line() -> None:
    assert {*LINES, "none"} == {*get_args(FailureCause)}
    assert why_lost(record(0), DECISIONS) == ""


@pytest.mark.parametrize("cause", LINES)
def test_the_line_of_a_cause(cause: str) -> None:
    seen = -1 if cause == "never_seen" else 20
    assert why_lost(record(0, success=False, failure_cause=cause, first_seen_step=seen), DECISIONS) == LINES[cause]


def test_where_done_was_said_is_left_out_without_decisions() -> None:
    lost = record(0, success=False, failure_cause="stopped_early", steps=45)
    assert why_lost(lost, ()) == "Done was said elsewhere at step 45; never seen before"
