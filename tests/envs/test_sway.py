"""The measure of how often orders sway a belief."""

from __future__ import annotations

import pytest

from tests.envs.sway import sway
from ucon.task.sets import load_episodes


@pytest.mark.parametrize("level", ["none", "full"])
def test_what_was_ordered_is_counted(level: str) -> None:
    episodes = load_episodes("mini")[::10]
    found = sway(episodes, level)
    if level == "none":
        assert found == {"episodes": len(episodes), "with_orders": 0}
        return
    assert found["with_orders"] == len(episodes)
    assert 4 <= found["orders_given"] <= 8
    assert 0 < found["places_ordered"] <= 4
    assert 0 <= found["belief_in_ordered_without"] < found["belief_in_ordered_with"] <= 1
