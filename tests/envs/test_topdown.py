"""The rendered map has the same orientation as the agent's own."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.envs.topdown import _AGENT, _START, _TARGET, TopDownMap
from ucon.sim.cache import load_house
from ucon.sim.state import SceneState
from ucon.task.sets import load_episodes

PX = 384


def middle(image: np.ndarray, color: tuple[int, int, int]) -> np.ndarray:
    """Mean column and row of the pixels of a colour, without the legend."""
    rows, columns = np.nonzero((image[: PX - 18] == color).all(2))
    return np.array([columns.mean(), rows.mean()])


@pytest.mark.parametrize("heading", range(4))
def test_what_lies_ahead_of_the_start_is_to_the_right(heading: int) -> None:
    episode = load_episodes("mini")[0]
    house = load_house(episode.scene)
    world = SceneState(house, episode.arrangement)
    drawn = TopDownMap(house, world.boxes, world.free, PX, heading)
    ahead, left = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])[[heading, (heading + 1) % 4]]
    x, y = house.grid.origin_xy
    here = np.array([x, y]) + 0.125 * np.array(house.grid.shape)
    goal = here + 2.0 * ahead + 1.0 * left
    box = np.array([*goal - 0.1, 0.5, *goal + 0.1, 0.7])
    image = drawn.draw([tuple(here), tuple(here + 1.0 * ahead)], heading, box, world.boxes[:0])
    assert image.shape == (PX, PX, 3)
    start, agent, target = (middle(image, color) for color in (_START, _AGENT, _TARGET))
    metre = np.abs(target - start).max() / 2.0
    assert agent[0] - start[0] == pytest.approx(metre, rel=0.35)
    assert abs(agent[1] - start[1]) < 3
    assert target - start == pytest.approx([2 * metre, -metre], abs=3)
