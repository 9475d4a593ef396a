"""The figures of a run, each computed by hand on a few records."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.evaluation.records import record
from ucon.core.errors import DataError
from ucon.evaluation.figures.metrics import MEASURES, episode_spl, summarise


def test_seen_is_seen_from_the_first_frame_on() -> None:
    """Step 0 is the frame before any action; -1 stands for never and is left out of the average."""
    figures = summarise([record(0, first_seen_step=0), record(1, first_seen_step=8), record(2, first_seen_step=-1)])
    assert figures["seen_rate"] == pytest.approx(2 / 3)
    assert figures["first_seen_step"] == pytest.approx(4.0)
    never = summarise([record(0, first_seen_step=-1)])
    assert never["seen_rate"] == 0.0
    assert never["first_seen_step"] is None


def test_every_figure_is_its_mean() -> None:
    first = {"opens": 3, "collisions": 4, "n_habits": 10, "recall_10": 0.25, "recall_20": 0.5, "mrr": 0.5}
    calls = {"language_calls": 2, "language_tokens": 30}
    figures = summarise([record(0, **first, **calls), record(1, success=False, **calls)])
    assert figures["opens"] == 2.0
    assert figures["collisions"] == 2.0
    assert figures["n_habits"] == 15.0
    assert figures["steps"] == 165.0
    assert figures["soft_spl"] == pytest.approx(0.3)
    assert figures["success_75"] == figures["success_150"] == figures["success_300"] == 0.5
    assert figures["path_length_m"] == 4.0
    assert figures["language_calls"] == 4, "a sum: what the run has cost"
    assert figures["language_tokens"] == 60
    assert figures["retrieval"] == {"recall_10": 0.375, "recall_20": 0.625, "mrr": 0.75}


def test_an_episode_without_recall_leaves_the_others_alone() -> None:
    figures = summarise([record(0, recall_10=None), record(1, recall_10=0.5)])
    assert figures["retrieval"]["recall_10"] == 0.5
    assert figures["retrieval"]["mrr"] == 1.0


def test_failures_are_counted_by_cause() -> None:
    causes = ("never_seen", "out_of_steps", "never_seen")
    records = [record(i, success=False, failure_cause=cause) for i, cause in enumerate(causes)]
    assert summarise([*records, record(3)])["failure_causes"] == {"never_seen": 2, "out_of_steps": 1}


def test_spl_may_be_rounded_but_not_wrong() -> None:
    right = record(0)
    assert summarise([replace(right, spl=right.spl + 0.9e-5)])["n"] == 1
    for wrong in (right.spl + 2e-5, right.spl - 2e-5):
        with pytest.raises(DataError, match="episode e0: SPL"):
            summarise([replace(right, spl=wrong)])
    with pytest.raises(DataError, match="no records"):
        summarise([])


def test_a_target_within_reach_of_the_start_asks_for_no_way() -> None:
    assert episode_spl(True, 0.0, 0.0) == 0.0
    assert episode_spl(True, 0.0, 1.0) == 0.0


def test_measures_are_those_of_the_records() -> None:
    one = record(0, success_75=False)
    found = {name: measure(one) for name, measure in MEASURES.items()}
    assert found == {
        "success_rate": 1.0,
        "spl": 0.5,
        "soft_spl": 0.5,
        "success_75": 0.0,
        "success_150": 1.0,
        "steps": 30.0,
        "path_length_m": 4.0,
    }
