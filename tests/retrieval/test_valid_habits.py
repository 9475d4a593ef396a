"""Habits that probably changed since they were told count less, in all readers and beside what the context says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ucon.habits.contexts import Context
from ucon.readers.anchor_reader import default_reader
from ucon.readers.conditions.condition_reader import counting, default_conditions
from ucon.readers.protocol import read_info

TEXTS = ("We keep the hardback on the sofa.", "We always put the hardback on the desk.")
SATURDAY = Context(day=5, hour=8, season="winter", occasion=None, asker="a family", user=None)


def belief(valid: list[float] | None, context: Context | None = None) -> dict[str, float]:
    found = default_reader().read(
        "hardback", TEXTS, trusted=True, context=context, valid=None if valid is None else np.array(valid)
    )
    one = found.belief(default_reader().known)
    return dict(zip(one.candidates, one.p, strict=True))


def test_counting_is_what_holds_times_what_is_valid() -> None:
    conditions, valid = default_conditions(), np.array([0.25, 1.0])
    assert counting(conditions, TEXTS, "fitted", None, None) is None
    assert counting(conditions, TEXTS, "fitted", None, valid) == pytest.approx(valid)
    holds = conditions.weights(TEXTS, SATURDAY, "fitted")
    assert (counting(conditions, TEXTS, "fitted", SATURDAY, None) == holds).all()
    both = counting(conditions, TEXTS, "fitted", SATURDAY, valid)
    assert both == pytest.approx(holds * valid, abs=1e-3)
    assert counting(conditions, (), "fitted", SATURDAY, np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("context", [None, SATURDAY, replace(SATURDAY, day=0)])
def test_belief_moves_from_what_no_longer_holds_to_what_does(context: Context | None) -> None:
    plain, sofa, desk = (belief(valid, context) for valid in ([1.0, 1.0], [1.0, 0.05], [0.05, 1.0]))
    assert sofa["sofa"] > plain["sofa"] > desk["sofa"]
    assert desk["desk"] > plain["desk"] > sofa["desk"]
    for p in (plain, sofa, desk):
        assert sum(p.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("context", [None, SATURDAY])
def test_where_all_is_valid_nothing_changes(context: Context | None) -> None:
    assert belief([1.0, 1.0], context) == pytest.approx(belief(None, context), abs=1e-5)


def test_what_holds_no_longer_leaves_its_place_less_than_common_sense_does() -> None:
    """That it was said of the place, and changed, speaks against it."""
    reader = default_reader()
    plain = dict(zip(reader.known, reader.read("hardback", ()).belief(reader.known).p, strict=True))
    gone = belief([0.0, 0.0])
    assert gone["sofa"] < plain["sofa"]
    assert gone["desk"] < plain["desk"]
    assert sum(gone.values()) == pytest.approx(1.0)


def test_an_info_says_it() -> None:
    info = {"target": "hardback", "habits": TEXTS, "habit_level": "gt"}
    reader = default_reader()
    plain = read_info(reader, info).belief(reader.known)
    told = read_info(reader, info | {"habits_valid": np.array([0.05, 1.0])}).belief(reader.known)
    sofa = plain.candidates.index("sofa")
    assert told.p[sofa] < plain.p[sofa]
