"""Small hand-written homes, and samples of the named scenes, for the tests in this folder."""

from __future__ import annotations

from functools import lru_cache

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Material
from ucon.scenes.spec import HomeSpec, Item, Opening, Room
from ucon.sim.compile import compile_house
from ucon.sim.house import House

FAST_SCENES = ("Rs_int", "Benevolence_1_int", "Ihlen_0_int")
GREY = (200, 200, 200)


def item(category: str, x: float, y: float, turns: int = 0, room: int = 0, z: float = 0.0) -> Item:
    return Item(category, catalogue()[category].size, (x, y, z), turns, room)


def hand_spec(*extra: Item, gap: bool = True) -> HomeSpec:
    """Two rooms of 5 by 4 m, a doorway between them, and six pieces of furniture."""
    rooms = (
        Room("kitchen_0", "kitchen", (0.0, 0.0, 5.0, 4.0), GREY, Material.TILE, GREY),
        Room("living_room_0", "living_room", (5.0, 0.0, 10.0, 4.0), GREY, Material.PARQUET, GREY),
    )
    items = (
        item("bottom_cabinet", 0.3, 1.0),
        item("breakfast_table", 2.5, 2.5),
        item("sofa", 9.4, 2.0, 2, 1),
        item("pedestal_table", 8.0, 2.0, 2, 1),
        item("fridge", 0.45, 3.0),
        item("wicker_basket", 5.4, 0.4, 0, 1),
    )
    openings = (Opening(0, 5.0, 1.5, 2.5, 0, 1),) if gap else ()
    return HomeSpec("hand", "house", 2.4, rooms, openings, items + extra)


@lru_cache(maxsize=1)
def hand_house() -> House:
    return compile_house(hand_spec())
