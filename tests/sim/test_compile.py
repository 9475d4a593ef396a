import numpy as np
import pytest

from tests.sim.homes import FAST_SCENES, hand_house, hand_spec, item
from tests.timing import fastest_s
from ucon.core.errors import SceneError
from ucon.scenes import SCENES, home_spec
from ucon.scenes.library import built_home
from ucon.sim.checks import openables
from ucon.sim.compile import compile_house
from ucon.sim.navgrid import AGENT_RADIUS_M
from ucon.sim.shapes import item_solid, item_turn, primitive_boxes
from ucon.sim.world import World

ALL_SCENES = [pytest.param(n, marks=[] if n in FAST_SCENES else pytest.mark.slow) for n in SCENES]


def test_free_nodes_keep_their_distance_from_every_part():
    house = hand_house()
    nodes = house.grid.xy(np.argwhere(house.grid.free))
    for thing in house.spec.items:
        boxes = primitive_boxes(item_solid(thing), thing.position, item_turn(thing))
        boxes = boxes[(boxes[:, 5] > 0.05) & (boxes[:, 2] < 1.8)]
        gap = np.maximum(np.maximum(boxes[:, None, :2] - nodes, nodes - boxes[:, None, 3:5]), 0.0)
        assert np.hypot(gap[..., 0], gap[..., 1]).min() > AGENT_RADIUS_M - 0.002


def test_no_node_is_lost_in_the_open():
    house = hand_house()
    i, j = house.grid.cell((6.5, 2.0))
    assert house.grid.free[i - 1 : i + 2, j - 1 : j + 2].all()
    doorway = house.grid.cell((5.01, 1.9))
    assert house.grid.free[doorway]


def test_overlapping_items_are_named():
    with pytest.raises(SceneError, match=r"breakfast_table #1 .* and armchair #6 .* overlap by \d+ mm"):
        compile_house(hand_spec(item("armchair", 2.5, 2.5)))


def test_a_joint_that_hits_something_is_named():
    with pytest.raises(SceneError, match=r"fridge #4 in kitchen_0 opened to \d+% hits armchair #6"):
        compile_house(hand_spec(item("armchair", 1.35, 3.0)))


def test_a_home_in_pieces_is_an_error():
    with pytest.raises(SceneError, match="pieces"):
        compile_house(hand_spec(gap=False))


@pytest.mark.parametrize("name", ALL_SCENES)
@pytest.mark.timed
def test_scenes_compile_in_a_second(name):
    """This includes layout, furnishing, building in PyBullet and checks, starting from the name."""

    def build():
        built_home.cache_clear()
        return compile_house(home_spec(name))

    house = build()
    assert fastest_s(build) < 1.0
    assert house.boxes.shape == (house.n_instances, 6)
    rooms, counts = np.unique(house.grid.room[house.grid.free], return_counts=True)
    assert len(rooms) == len(house.spec.rooms)
    assert counts.min() >= 5
    assert openables(house.spec)


@pytest.mark.parametrize("name", ALL_SCENES)
def test_boxes_are_those_of_bullet(name):
    house = compile_house(home_spec(name), check=False)
    with World(house) as world:
        live = world.boxes()
    assert np.abs(live - house.boxes).max() < 1e-6
