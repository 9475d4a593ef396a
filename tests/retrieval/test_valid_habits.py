"""Habits that may have changed since they were told: the belief is a mixture over the possibilities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from models.nets.belief.head_reader import HeadReader
from ucon.habits.contexts import Context
from ucon.perception.belief.from_habits import ReadHabits
from ucon.perception.belief.target_belief import Locations
from ucon.readers.anchor_reader import default_reader
from ucon.readers.conditions.condition_reader import counting, default_conditions

SOFA, DESK = "We keep the hardback on the sofa.", "We always put the hardback on the desk."
SATURDAY = Context(day=5, hour=8, season="winter", occasion=None, asker="a family", user=None)


@pytest.fixture(params=["fitted", "head"], scope="module")
def read(request: pytest.FixtureRequest) -> ReadHabits:
    return ReadHabits(default_reader() if request.param == "fitted" else HeadReader.load())  # type: ignore[arg-type]


def located(read: ReadHabits, texts: tuple[str, ...], valid: list[float] | None = None, **more: Any) -> Locations:
    info = {"target": "hardback", "habits": texts, **more}
    return read(info if valid is None else info | {"habits_valid": np.array(valid)})


@pytest.mark.parametrize("more", [{}, {"told": SATURDAY}, {"habit_level": "gt"}])
def test_it_is_a_mixture_of_what_may_be(read: ReadHabits, more: dict[str, Any]) -> None:
    """With probability .2 both sentences hold, with .5 only the later one, with .3 neither."""
    both, later, none = (located(read, texts, **more).p for texts in ((SOFA, DESK), (DESK,), ()))
    found = located(read, (SOFA, DESK), [0.2, 0.7], **more)
    assert found.p == pytest.approx(0.2 * both + 0.5 * later + 0.3 * none)
    assert found.habits == (SOFA, DESK)


@pytest.mark.parametrize("valid", [None, [1.0, 1.0]])
def test_where_all_is_valid_nothing_changes(read: ReadHabits, valid: list[float] | None) -> None:
    plain = located(read, (SOFA, DESK))
    assert (located(read, (SOFA, DESK), valid).p == plain.p).all()
    assert located(read, (), []).p == pytest.approx(located(read, ()).p)


def test_what_holds_no_longer_says_nothing(read: ReadHabits) -> None:
    assert located(read, (SOFA, DESK), [0.0, 0.0]).p == pytest.approx(located(read, ()).p)


def test_reasons_count_less_too(read: ReadHabits) -> None:
    plain, found = located(read, (SOFA, DESK)), located(read, (SOFA, DESK), [0.25, 1.0])
    assert plain.relevance is not None
    assert plain.support is not None
    assert found.relevance == pytest.approx(plain.relevance * [0.25, 1.0])
    assert found.support is not None
    assert found.support("sofa") == pytest.approx(plain.support("sofa") * [0.25, 1.0])


def test_counting_is_what_holds_times_what_is_valid() -> None:
    conditions, valid, texts = default_conditions(), np.array([0.25, 1.0]), (SOFA, DESK)
    assert counting(conditions, texts, "language", None, None) is None
    assert counting(conditions, texts, "language", None, valid) == pytest.approx(valid)
    holds = conditions.weights(texts, SATURDAY, "language")
    assert (counting(conditions, texts, "language", SATURDAY, None) == holds).all()
    assert counting(conditions, texts, "language", SATURDAY, valid) == pytest.approx(holds * valid, abs=1e-3)
    assert counting(conditions, (), "language", SATURDAY, np.zeros(0)).shape == (0,)
