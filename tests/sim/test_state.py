import time

import numpy as np
import pytest

from tests.sim.homes import hand_house
from tests.sim.test_world import BASKET, FRIDGE, TABLE, arranged
from ucon.core.errors import EpisodeError
from ucon.sim.arrangement import Arrangement
from ucon.sim.navgrid import free_cells
from ucon.sim.state import SceneState
from ucon.sim.world import World


@pytest.mark.timed
def test_reset_takes_less_than_a_millisecond():
    house, arrangement = arranged()
    SceneState(house, arrangement)
    start = time.process_time()
    for _ in range(200):
        SceneState(house, arrangement)
    assert (time.process_time() - start) / 200 < 1e-3


def test_open_flags_and_who_can_be_opened():
    state = SceneState(*arranged())
    assert state.openable[FRIDGE]
    assert not state.openable[TABLE]
    assert state.removed[BASKET]
    state.set_open(FRIDGE)
    assert state.open[FRIDGE]
    state.set_open(FRIDGE, False)
    assert not state.open.any()
    with pytest.raises(EpisodeError, match="breakfast_table"):
        state.set_open(TABLE)


def test_an_arrangement_of_another_home_is_an_error():
    with pytest.raises(EpisodeError, match="another version"):
        SceneState(hand_house(), Arrangement(removed=(999,)))


def test_compiled_and_live_floor_agree():
    house, arrangement = arranged()
    state = SceneState(house, Arrangement((), arrangement.objects, arrangement.blocked))
    with World(house) as world:
        world.apply(Arrangement((), arrangement.objects))
        live = free_cells(world, house.grid.origin_xy, house.grid.room) & house.grid.free
    assert arrangement.blocked
    assert not (state.free & ~live).any()
    # The compiled state uses a round object's box, so it may block a node that is free in the live world.
    assert (live & ~state.free).sum() <= 2


def test_distance_is_to_the_nearest_point_of_the_box():
    state = SceneState(hand_house())
    box = state.boxes[TABLE]
    away = state.horizontal_distance(box[3] + 0.3, box[4] + 0.4)
    assert away[TABLE] == pytest.approx(0.5)
    assert state.horizontal_distance(*((box[:2] + box[3:5]) / 2))[TABLE] == 0.0
    assert np.isfinite(away).all()
