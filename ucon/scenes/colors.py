"""Materials and colours of floors and walls by room type, with seeded variants."""

from __future__ import annotations

from ucon.core.rng import stream
from ucon.objects.model import Material

RGB = tuple[int, int, int]

PARQUET: tuple[RGB, ...] = ((168, 124, 80), (190, 150, 104), (142, 98, 62), (204, 172, 128))
TILE: tuple[RGB, ...] = ((206, 208, 204), (180, 188, 196), (222, 212, 196), (150, 158, 160))
CARPET: tuple[RGB, ...] = ((150, 144, 158), (128, 146, 150), (170, 150, 132), (118, 128, 150))
CONCRETE: tuple[RGB, ...] = ((150, 150, 148), (134, 136, 140), (164, 160, 152))
GRASS: tuple[RGB, ...] = ((96, 140, 70), (84, 128, 62), (110, 150, 80))
HEDGE: tuple[RGB, ...] = ((70, 108, 58), (82, 118, 64), (62, 98, 60))
WALLS: tuple[RGB, ...] = (
    (236, 232, 222),
    (226, 234, 240),
    (240, 228, 214),
    (224, 236, 222),
    (240, 222, 222),
    (230, 224, 240),
    (244, 238, 206),
    (214, 230, 232),
    (232, 214, 198),
    (222, 222, 222),
)

_FLOORS: dict[str, tuple[Material, tuple[RGB, ...]]] = {
    "bathroom": (Material.TILE, TILE),
    "kitchen": (Material.TILE, TILE),
    "utility_room": (Material.TILE, TILE),
    "pantry_room": (Material.TILE, TILE),
    "grocery_store": (Material.TILE, TILE),
    "sauna": (Material.WOOD, PARQUET),
    "bar": (Material.TILE, TILE),
    "lobby": (Material.TILE, TILE),
    "break_room": (Material.TILE, TILE),
    "garage": (Material.CONCRETE, CONCRETE),
    "storage_room": (Material.CONCRETE, CONCRETE),
    "exercise_room": (Material.CONCRETE, CONCRETE),
    "shared_office": (Material.FABRIC, CARPET),
    "private_office": (Material.FABRIC, CARPET),
    "meeting_room": (Material.FABRIC, CARPET),
    "conference_hall": (Material.FABRIC, CARPET),
    "television_room": (Material.FABRIC, CARPET),
    "childs_room": (Material.FABRIC, CARPET),
    "playroom": (Material.FABRIC, CARPET),
    "garden": (Material.GRASS, GRASS),
}


def floor_of(room_type: str, seed: int, room: str) -> tuple[RGB, Material]:
    """Colour and material of a floor; all parquet rooms of a home have the same colour.

    Args:
        room_type: type of the room.
        seed: of the home.
        room: its name.
    """
    material, colors = _FLOORS.get(room_type, (Material.PARQUET, PARQUET))
    key = "parquet" if material == Material.PARQUET else room
    return colors[int(stream(seed, "floor", key).integers(len(colors)))], material


def wall_colors(types: list[str], seed: int) -> list[RGB]:
    """One light colour for each room; neighbours in the list differ. Gardens have hedges.

    Args:
        types: type of each room.
        seed: of the home.
    """
    order = stream(seed, "walls").permutation(len(WALLS))
    found = []
    for index, room_type in enumerate(types):
        if room_type == "garden":
            found.append(HEDGE[int(stream(seed, "hedge").integers(len(HEDGE)))])
        else:
            found.append(WALLS[int(order[index % len(WALLS)])])
    return found
