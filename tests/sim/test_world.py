import gc
import os
from pathlib import Path

import numpy as np
import pytest

from tests.sim.homes import hand_house, hand_spec
from ucon.core.rng import stream
from ucon.sim.arrangement import Arrangement
from ucon.sim.placement import place, with_object
from ucon.sim.state import SceneState
from ucon.sim.world import World

CABINET, TABLE, FRIDGE, BASKET = 0, 1, 4, 5


def arranged():
    house, arrangement = hand_house(), Arrangement(removed=(BASKET,))
    for category, relation, anchor in [
        ("apple", "ontop", TABLE),
        ("hardback", "inside", CABINET),
        ("coffee_cup", "inside", FRIDGE),
        ("pot_plant", "nextto", TABLE),
    ]:
        placed = place(house, arrangement, category, relation, anchor, stream(1, category))
        arrangement = with_object(house, arrangement, placed)
    return house, arrangement


def test_apply_is_what_the_compiled_state_says_and_can_be_undone():
    house, arrangement = arranged()
    state = SceneState(house, arrangement)
    with World(house) as world:
        before = world.poses()
        world.apply(arrangement)
        live = world.boxes()
        present = ~state.removed
        assert np.abs(live - state.boxes)[present].max() < 1e-5
        assert set(world.instances) == set(np.flatnonzero(present).tolist())
        world.apply(Arrangement())
        assert world.poses() == before


def test_opening_is_a_joint_value_and_moves_the_box():
    house = hand_house()
    with World(house) as world:
        closed = world.boxes()[FRIDGE]
        world.set_open(FRIDGE, 1.0)
        assert world.openness(FRIDGE) == pytest.approx(1.0)
        assert (world.boxes()[FRIDGE] - closed)[3:].max() > 0.2
        world.set_open(FRIDGE, 0.0)
        assert np.allclose(world.boxes()[FRIDGE], closed)


def test_contacts_name_who_touches():
    house, arrangement = arranged()
    with World(house) as world:
        world.apply(arrangement)
        apple = house.n_instances
        touching = world.contacts(apple)
        assert set(touching) == {TABLE}
        assert touching[TABLE] > -0.002


def test_nothing_leaks_over_500_worlds():
    spec = hand_spec()
    for _ in range(20):
        World(spec).close()
    gc.collect()
    files, memory = _files(), _memory()
    for _ in range(500):
        with World(spec):
            pass
    gc.collect()
    assert _files() == files
    assert _memory() - memory < 8e6


def test_500_rearrangements_leak_no_bodies():
    house, arrangement = arranged()
    with World(house) as world:
        count = world.bullet.getNumBodies(physicsClientId=world.client)
        for _ in range(250):
            world.apply(arrangement)
            world.apply(Arrangement())
        assert world.bullet.getNumBodies(physicsClientId=world.client) == count


def _files():
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.is_dir() else 0


def _memory():
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if statm.is_file() else 0
