"""Adds furniture that measured inventories lack: a bin in the bathroom, content in closets.

The inventories count fixed furniture well and small furniture badly. Each room type lists modest, plausible additions.
A house or flat as a whole then gets the common anchors it still lacks, in a room where they belong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ucon.core.rng import stream
from ucon.scenes.program import HomeProgram, RoomProgram

#: By room type: (category, probability); skipped where the room has the category already.
ADDITIONS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "closet": (("wardrobe", 0.75), ("shelf", 0.35), ("storage_box", 0.7), ("hamper", 0.5), ("hat", 0.3)),
    "storage_room": (("shelf", 1.0), ("storage_box", 0.8), ("toolbox", 0.4), ("bucket", 0.5), ("wicker_basket", 0.4)),
    "empty_room": (("shelf", 0.8), ("storage_box", 0.6), ("picture", 0.5)),
    "staircase": (("console_table", 0.6), ("picture", 0.8), ("pot_plant", 0.5)),
    "corridor": (("console_table", 0.5), ("picture", 0.8), ("pot_plant", 0.5), ("carpet", 0.4), ("mirror", 0.3)),
    "entryway": (("hall_tree", 0.6), ("mirror", 0.5), ("carpet", 0.6), ("gym_shoe", 0.5), ("shoulder_bag", 0.4)),
    "pantry_room": (("shelf", 1.0), ("storage_box", 0.5), ("jar", 0.7), ("canister", 0.5)),
    "bathroom": (("trash_can", 0.7), ("towel_rack", 0.7), ("carpet", 0.4), ("hamper", 0.25), ("soap_dispenser", 0.5)),
    "bedroom": (("table_lamp", 0.8), ("pillow", 1.0), ("carpet", 0.5), ("picture", 0.6), ("wardrobe", 0.5)),
    "childs_room": (("pillow", 1.0), ("toy_box", 0.5), ("carpet", 0.6), ("table_lamp", 0.4), ("hardback", 0.5)),
    "living_room": (("pillow", 0.9), ("pot_plant", 0.6), ("carpet", 0.7), ("magazine", 0.5), ("vase", 0.4)),
    "television_room": (("pillow", 0.9), ("carpet", 0.7), ("floor_lamp", 0.5), ("magazine", 0.4)),
    "kitchen": (("trash_can", 0.9), ("kettle", 0.5), ("toaster", 0.4), ("bowl", 0.5), ("cutting_board", 0.5)),
    "dining_room": (("vase", 0.5), ("pot_plant", 0.4)),
    "private_office": (("trash_can", 0.5), ("table_lamp", 0.5), ("notebook", 0.5), ("pencil_holder", 0.5)),
    "utility_room": (("wicker_basket", 0.7), ("detergent_bottle", 0.7), ("bucket", 0.4)),
    "garage": (("shelf", 0.8), ("bottom_cabinet", 0.6), ("recycling_bin", 0.6), ("toolbox", 0.8), ("storage_box", 0.8)),
    "playroom": (("toy_figure", 0.6), ("storage_box", 0.4)),
    "exercise_room": (("bench", 0.6), ("electric_fan", 0.4), ("water_bottle", 0.5)),
    "phone_room": (("straight_chair", 1.0),),
    "copy_room": (("shelf", 0.7), ("paper_sheet", 0.6)),
    "sauna": (("bench", 0.5), ("bucket", 0.6)),
}
#: By room type: small things on tables and shelves, as (category, probability, most).
DAILY: Mapping[str, tuple[tuple[str, float, int], ...]] = {
    "living_room": (("hardback", 0.8, 4), ("candle_holder", 0.4, 1), ("picture_frame", 0.5, 2), ("bowl", 0.3, 1)),
    "television_room": (("hardback", 0.7, 4), ("picture_frame", 0.4, 1), ("mug", 0.4, 1)),
    "bedroom": (("paperback_book", 0.6, 2), ("alarm_clock", 0.5, 1), ("picture_frame", 0.5, 2), ("vase", 0.2, 1)),
    "childs_room": (("paperback_book", 0.7, 3), ("toy_figure", 0.7, 2), ("pencil_holder", 0.5, 1)),
    "kitchen": (("plate", 0.6, 3), ("mug", 0.7, 3), ("jar", 0.5, 2), ("soap_dispenser", 0.5, 1), ("stockpot", 0.5, 1)),
    "dining_room": (("bowl", 0.5, 1), ("candle_holder", 0.4, 2), ("plate", 0.3, 4)),
    "bathroom": (("hand_towel", 0.5, 1), ("bottle_of_shampoo", 0.5, 1)),
    "private_office": (("hardback", 0.8, 4), ("folder", 0.5, 2), ("mug", 0.4, 1)),
    "playroom": (("hardback", 0.6, 3), ("toy_figure", 0.6, 2)),
    "corridor": (("vase", 0.4, 1), ("picture_frame", 0.3, 1)),
    "entryway": (("hat", 0.4, 1), ("vase", 0.3, 1)),
    "storage_room": (("jar", 0.3, 2), ("canister", 0.3, 2)),
    "closet": (("gym_shoe", 0.4, 1), ("shoulder_bag", 0.3, 1)),
    "garage": (("bucket", 0.4, 1),),
    "pantry_room": (("canister", 0.5, 3), ("bottle_of_wine", 0.4, 2)),
}
#: By room type: categories that are always there.
ESSENTIAL: Mapping[str, tuple[str, ...]] = {"bathroom": ("sink", "toilet", "mirror"), "bedroom": ("bed",)}
#: Common anchors a house or flat should have, and the room types they belong in, best first.
COMMON: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("sofa", ("living_room", "television_room")),
    ("wall_mounted_tv", ("living_room", "television_room", "bedroom")),
    ("coffee_table", ("living_room", "television_room", "playroom")),
    ("armchair", ("living_room", "television_room", "bedroom", "playroom")),
    ("breakfast_table", ("dining_room", "kitchen", "living_room", "private_office", "bedroom")),
    ("straight_chair", ("dining_room", "kitchen", "living_room", "bedroom", "childs_room", "empty_room")),
    ("shelf", ("living_room", "bedroom", "television_room", "storage_room", "closet", "empty_room")),
    ("bottom_cabinet", ("living_room", "bedroom", "corridor", "entryway")),
    ("countertop", ("kitchen", "utility_room")),
    ("bottom_cabinet_no_top", ("kitchen", "utility_room")),
    ("top_cabinet", ("kitchen", "utility_room", "bathroom")),
    ("trash_can", ("kitchen", "bathroom", "private_office")),
    ("floor_lamp", ("living_room", "television_room", "bedroom")),
    ("table_lamp", ("bedroom", "living_room", "private_office")),
    ("pot_plant", ("living_room", "television_room", "corridor", "entryway")),
    ("carpet", ("living_room", "bedroom", "entryway", "corridor")),
    ("washer", ("utility_room", "storage_room", "garage")),
    ("mirror", ("bathroom", "entryway", "bedroom")),
    ("bed", ("bedroom",)),
)
ROOMY_M2 = 7.0
"""Rooms smaller than this get no large additions, square metres."""
LARGE = ("wardrobe", "hall_tree", "carpet", "armchair", "sofa", "coffee_table")


def enriched(program: HomeProgram, seed: int) -> HomeProgram:
    """The program with additions.

    Each addition has its own random stream, so that none changes another.

    Args:
        program: rooms and furniture of a home.
        seed: of the additions.
    """
    rooms = [_room(room, seed, program.kind) for room in program.rooms]
    if program.kind in ("house", "flat"):
        for category, types in COMMON:
            same = (category, "standing_tv") if category == "wall_mounted_tv" else (category,)
            if not any(c in r.furniture for r in rooms for c in same):
                _give(rooms, category, types)
    return replace(program, rooms=tuple(rooms))


def _room(room: RoomProgram, seed: int, kind: str) -> RoomProgram:
    furniture = dict(room.furniture)
    area = room.size_m[0] * room.size_m[1]
    if kind in ("house", "flat"):
        for category in ESSENTIAL.get(room.type, ()):
            furniture.setdefault(category, 1)
        if room.type == "bathroom" and not furniture.keys() & {"bathtub", "shower_stall", "shower"} and area >= 5.0:
            furniture["shower_stall"] = 1
        if room.type == "bedroom" and not furniture.keys() & {"nightstand", "bottom_cabinet", "drawer_unit"}:
            furniture["nightstand"] = 1
    for category, share in ADDITIONS.get(room.type, ()):
        if stream(seed, "enrich", room.name, category).random() >= share or category in room.surface:
            continue
        if category in furniture or (category in LARGE and area < ROOMY_M2 and room.type not in ("closet", "entryway")):
            continue
        if kind not in ("house", "flat") and room.type in ("bathroom", "corridor", "dining_room"):
            continue
        furniture[category] = 1
    for category, share, most in DAILY.get(room.type, ()) if kind in ("house", "flat") else ():
        rng = stream(seed, "daily", room.name, category)
        if rng.random() < share and category not in furniture and category not in room.surface:
            furniture[category] = int(rng.integers(1, most + 1))
    return replace(room, furniture=furniture)


def _give(rooms: list[RoomProgram], category: str, types: tuple[str, ...]) -> None:
    for room_type in types:
        best = [i for i, r in enumerate(rooms) if r.type == room_type]
        if best:
            index = max(best, key=lambda i: (rooms[i].size_m[0] * rooms[i].size_m[1], -i))
            rooms[index] = replace(rooms[index], furniture={**rooms[index].furniture, category: 1})
            return
