"""From habits to expectations: movable anchors are followed by the share that was asked for."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.perception.belief import Locations
from ucon.perception.reading import ReadHabits

HABITS = ["The pen always lies on the notebook.", "The notebook is kept in the fridge, of all places."]


def read(follow: float) -> Locations:
    return ReadHabits(follow=follow)({"habits": HABITS, "target": "pen", "habit_level": "full"})


def test_a_share_of_what_is_by_a_movable_anchor_goes_on() -> None:
    stays, half, goes = read(0.0), read(0.5), read(1.0)
    assert stays.names == half.names == goes.names
    row = {name: k for k, name in enumerate(stays.names)}
    assert goes.p[row["fridge"]].sum() > stays.p[row["fridge"]].sum() + 0.05
    assert goes.p[row["notebook"]].sum() == 0.0 < 0.1 < stays.p[row["notebook"]].sum()
    for locations in (half, goes):
        assert locations.p.sum() == pytest.approx(stays.p.sum())
    np.testing.assert_allclose(half.p.sum(1), (stays.p.sum(1) + goes.p.sum(1)) / 2)


def test_a_share_is_a_share() -> None:
    with pytest.raises(ConfigError, match=r"follow=1.5: expected a share from 0 to 1"):
        ReadHabits(follow=1.5)
    with pytest.raises(ConfigError, match=r"follow=half: expected a share"):
        ReadHabits(follow="half")  # type: ignore[arg-type]
