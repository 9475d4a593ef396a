import numpy as np
import pytest

from tests.sim.homes import FAST_SCENES
from tests.sim.triples import house_of, triples, with_imported
from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.scenes import SCENES
from ucon.sim.arrangement import Arrangement
from ucon.sim.placement import RefusedError, import_anchor, importable, place, with_object
from ucon.sim.placement.importing import MAX_WALL_WIDTH_M
from ucon.sim.world import World

FIXED = ("bathtub", "stove", "piano", "bed", "treadmill", "pool_table", "countertop", "bottom_cabinet", "walls", "door")
MOVABLE = ("suitcase", "cedar_chest", "hamper", "wicker_basket", "storage_box", "picture", "mirror", "notebook", "vase")


def test_what_is_importable():
    assert not [name for name in FIXED if importable(name)]
    assert not [name for name in MOVABLE if not importable(name)]
    assert all(catalogue()[n].size[1] <= MAX_WALL_WIDTH_M for n in catalogue().names if importable(n) and _is_wall(n))


def _is_wall(name):
    return catalogue()[name].mount == "wall"


def test_fixed_things_are_refused():
    with pytest.raises(RefusedError, match="not_importable"):
        import_anchor(house_of("Rs_int"), Arrangement(), "piano", stream(0, "x"))


def failures(names, scenes):
    failed = []
    for number, category in enumerate(names):
        name = scenes[number % len(scenes)]
        try:
            with_imported(name, category)
        except RefusedError as error:
            failed.append((category, name, error.reason))
    return failed


def wanted():
    return sorted({triple.anchor for triple in triples() if importable(triple.anchor)})


def test_a_sample_of_anchors_can_be_imported():
    names = wanted()[::8]
    assert len(failures(names, FAST_SCENES)) <= 0.02 * len(names) + 1


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_every_importable_anchor_can_be_imported(scene):
    names = wanted()
    failed = failures(names, (scene,))
    assert len(failed) <= 0.02 * len(names), failed


@pytest.mark.parametrize("category", ["suitcase", "cedar_chest", "hamper", "notebook", "picture", "mirror"])
def test_imported_things_stand_free_in_the_live_world(category):
    house = house_of("Ihlen_0_int")
    arrangement, instance = with_imported("Ihlen_0_int", category)
    placed = arrangement.objects[0]
    assert placed.relation == "imported"
    with World(house) as world:
        world.apply(arrangement)
        contacts = world.contacts(instance, 0.006)
        assert contacts
        assert min(contacts.values()) > -0.003
        assert placed.anchor in contacts


@pytest.mark.parametrize("category", ["suitcase", "cedar_chest"])
def test_an_imported_container_holds_things(category):
    house = house_of("Ihlen_0_int")
    arrangement, instance = with_imported("Ihlen_0_int", category)
    placed = place(house, arrangement, "sandal", "inside", instance, stream(0, "inside"))
    assert placed.anchor == placed.holder == instance
    with World(house) as world:
        world.apply(with_object(house, arrangement, placed))
        world.set_open(instance, 1.0)
        assert world.openness(instance) == pytest.approx(1.0)
        assert min(world.contacts(instance + 1).values()) > -0.003


def test_wall_things_hang_on_the_wall():
    house = house_of("Ihlen_0_int")
    placed = with_imported("Ihlen_0_int", "picture")[0].objects[0]
    room = house.spec.rooms[placed.room]
    sides = np.array(room.rect) - np.array([*placed.position[:2], *placed.position[:2]])
    assert np.abs(sides).min() < 0.12
    assert placed.position[2] > 0.8
