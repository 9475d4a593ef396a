"""Replayed runs: which episodes count as the same, and which runs are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.evaluation.records import record
from ucon.core.errors import DataError
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.replayed import StoredRun, replayed

RECORDS = [record(0), record(1, success=False)]
FIGURES = summarise(RECORDS)


def compared(**changes: object) -> tuple[str, ...]:
    return replayed(StoredRun("belief", FIGURES | changes, None), RECORDS).differing


def test_figures_that_are_the_same_differ_in_nothing() -> None:
    assert compared() == ()
    assert compared(spl=FIGURES["spl"] + 0.9e-6) == (), "as summaries are rounded"


@pytest.mark.parametrize(
    "changes",
    [
        {"spl": FIGURES["spl"] + 1e-5},
        {"n": 3},
        {"failure_causes": {"out_of_steps": 1}},
        {"failure_causes": {"never_seen": 2}},
        {"failure_causes": {"never_seen": 1, "out_of_steps": 0}},
        {"spl_ci95": [0.0]},
        {"spl_ci95": [0.0, 0.4]},
        {"retrieval": FIGURES["retrieval"] | {"mrr": 0.5}},
        {"retrieval": FIGURES["retrieval"] | {"mrr": None}},
    ],
    ids=str,
)
def test_every_figure_that_differs_is_named(changes: dict[str, object]) -> None:
    assert compared(**changes) == tuple(changes)


def test_figures_that_older_summaries_lack_are_no_difference() -> None:
    kept = {name: value for name, value in FIGURES.items() if name not in ("soft_spl", "retrieval")}
    assert replayed(StoredRun("belief", kept, None), RECORDS).same


def test_episodes_are_compared_one_by_one() -> None:
    kept = StoredRun("belief", FIGURES, RECORDS)
    assert replayed(kept, RECORDS).same
    found = replayed(kept, [RECORDS[0], replace(RECORDS[1], steps=299)])
    assert (found.by, found.differing, found.same, found.n) == ("episodes", ("e1",), False, 2)
    assert replayed(kept, RECORDS[:1], every=2).same


def test_a_part_can_be_played_only_where_episodes_are_kept() -> None:
    StoredRun("belief", FIGURES, RECORDS).check(["e0"], every=2)
    with pytest.raises(DataError, match="now names other episodes"):
        StoredRun("belief", FIGURES, RECORDS).check(["e1"], every=2)
    with pytest.raises(DataError, match="no episodes are kept"):
        StoredRun("belief", FIGURES, None).check(["e0"], every=2)
    with pytest.raises(DataError, match="now names other episodes"):
        StoredRun("belief", FIGURES, None).check(["e0"])
