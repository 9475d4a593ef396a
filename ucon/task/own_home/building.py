"""Builds a user's own home: rooms and doors as its file describes them, the rest drawn as in generated homes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from ucon.core.errors import SceneError
from ucon.scenes.furnishing.enrich import enriched
from ucon.scenes.furnishing.fixtures import LIGHTS
from ucon.scenes.home import build_program
from ucon.scenes.own import keep_program, own_name
from ucon.scenes.procedural import drawn_room, joined, numbered, procedural_program, usual_joint
from ucon.scenes.program import HomeProgram, RoomProgram, check_program
from ucon.scenes.room_types import NO_WINDOWS
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.task.own_home.wish import Door, OwnHome, OwnRoom, Thing

_WALL_HEIGHT_M: Final = 2.5
_FIXTURES: Final = ("window", "electric_switch", *LIGHTS)
#: By how much a room is enlarged to find out whether the furniture then fits, metres.
_ENLARGED_M: Final = (0.5, 1.0, 1.5, 2.0, 3.0)


@dataclass(frozen=True)
class Unplaced:
    """Furniture of the home file that could not be placed.

    Attributes:
        room: name of the room in the home file.
        category: category of the furniture.
        wanted: how many pieces the file asks for.
        placed: how many of them were placed.
        where: file and line.
        nearest: what can be built instead, in words; "" if this was not asked for.
    """

    room: str
    category: str
    wanted: int
    placed: int
    where: str
    nearest: str

    def __str__(self) -> str:
        name = self.category.replace("_", " ")
        if self.wanted == 1:
            told = "it does not fit"
        else:
            told = f"{self.placed or 'none'} of {'' if self.placed else 'the '}{self.wanted} fit"
        return f"{self.where}: {self.room}: {name}: {told}{f'; {self.nearest}' if self.nearest else ''}"


def program_of_home(wish: OwnHome) -> tuple[HomeProgram, dict[str, str]]:
    """The program of a home, and a dictionary from the program's room names to those of the home file.

    Args:
        wish: the home as its file describes it.
    """
    if not wish.rooms:
        program = procedural_program(wish.kind, wish.seed)
        called = {room.name: room.name.replace("_", " ") for room in program.rooms}
        return enriched(program, wish.seed), called
    names = numbered([room.type for room in wish.rooms])
    by_call = dict(zip((room.called for room in wish.rooms), names, strict=True))
    hub = _hub(wish, by_call)
    types = dict(zip(names, (room.type for room in wish.rooms), strict=True))
    edges = _edges(wish.doors, by_call, types, hub, wish.kind)
    rooms = [_room(room, by_call[room.called], wish, edges) for room in wish.rooms]
    program = HomeProgram(wish.kind, _WALL_HEIGHT_M, hub, tuple(rooms), tuple(edges))
    said = {by_call[room.called] for room in wish.rooms if room.furniture is not None}
    more = {room.name: room for room in enriched(program, wish.seed).rooms}
    program = replace(program, rooms=tuple(r if r.name in said else more[r.name] for r in rooms))
    check_program(wish.called, program)
    return program, {name: call for call, name in by_call.items()}


def build(wish: OwnHome) -> tuple[str, House]:
    """Build a home, or load it if it was built before.

    Args:
        wish: the home as its file describes it.

    Returns:
        The home's name, and the home.

    Raises:
        SceneError: the home cannot be built.
        DataError: the home has to be built, and PyBullet is missing.
    """
    name = home_name(wish)
    try:
        return name, load_house(name)
    except SceneError as error:
        if wish.known:
            raise
        raise SceneError(
            f"{wish.where}: cannot be built like this ({error}); give another seed, or fewer things"
        ) from None


def home_name(wish: OwnHome) -> str:
    """The name of a home; its program is stored for :func:`ucon.sim.cache.load_house`.

    Args:
        wish: the home as its file describes it.
    """
    return wish.called if wish.known else keep_program(wish.called, program_of_home(wish)[0], wish.seed)


def rooms_by_name(wish: OwnHome, house: House) -> dict[str, str]:
    """Names of the rooms in the home file, by their names in the built home.

    Args:
        wish: the home as its file describes it.
        house: the home as built.
    """
    called = {} if wish.known else program_of_home(wish)[1]
    legs = {room.name: room.name.removesuffix("_b") for room in house.spec.rooms}  # a folded corridor has a second leg
    return {name: called.get(leg, leg.replace("_", " ")) for name, leg in legs.items()}


def unplaced(wish: OwnHome, house: House, *, nearest: bool = True) -> list[Unplaced]:
    """Furniture of the home file that could not be placed, with the nearest that can be built.

    Args:
        wish: the home as its file describes it.
        house: the home as built.
        nearest: whether to find out what can be built instead, which builds the home up to five times per category.
    """
    if wish.known or not wish.rooms:
        return []
    program, called = program_of_home(wish)
    by_call = {call: name for name, call in called.items()}
    numbers = {room.name: number for number, room in enumerate(house.spec.rooms)}
    found = []
    for room in wish.rooms:
        inside = {numbers[by_call[room.called]], numbers.get(f"{by_call[room.called]}_b")}
        standing = [item.category for item in house.spec.items if item.room in inside]
        for category, thing in (room.furniture or {}).items():
            placed = standing.count(category)
            if placed < thing.count:
                instead = _nearest(wish, program, by_call[room.called], category, thing, placed) if nearest else ""
                found.append(Unplaced(room.called, category, thing.count, placed, thing.where, instead))
    return found


# -- the program ------------------------------------------------------------------------------------------------


def _hub(wish: OwnHome, by_call: dict[str, str]) -> str:
    """The room from which the others are reached: that with most doors, else a corridor, a living room or the first."""
    doors = [room for door in wish.doors or () for room in (door.first, door.second)]
    order = {"corridor": 0, "living_room": 1, "shared_office": 1, "lobby": 1, "grocery_store": 1}
    best = min(wish.rooms, key=lambda room: (-doors.count(room.called), order.get(room.type, 2)))
    return by_call[best.called]


def _edges(
    doors: Sequence[Door] | None, by_call: dict[str, str], types: dict[str, str], hub: str, kind: str
) -> list[tuple[str, str, str]]:
    """Openings as (room nearer the hub, room, kind of opening), parents before children."""
    if doors is None:
        return joined(list(types), list(types.values()), hub, kind)
    left = [(by_call[door.first], by_call[door.second], door.joint) for door in doors]
    found: list[tuple[str, str, str]] = []
    reached = [hub]
    for parent in reached:  # grows as rooms are reached
        for first, second, joint in [one for one in left if parent in one[:2]]:
            child = second if first == parent else first
            if child not in reached:
                reached.append(child)
                found.append((parent, child, joint or usual_joint(types[child])))
    return found


def _room(room: OwnRoom, name: str, wish: OwnHome, edges: Sequence[tuple[str, str, str]]) -> RoomProgram:
    drawn = drawn_room(name, room.type, wish.kind, wish.seed, edges)
    size, exact = room.size_m or drawn.size_m, room.size_m is not None
    if room.furniture is None:
        return replace(drawn, size_m=size, exact=exact)
    counts = {category: thing.count for category, thing in room.furniture.items()}
    fixtures = {"electric_switch": 1} | ({} if counts.keys() & set(LIGHTS) else {"room_light": 1})
    if room.type not in NO_WINDOWS:
        fixtures["window"] = 1
    fixtures |= {category: n for category, n in counts.items() if category in _FIXTURES}
    furniture = {category: n for category, n in counts.items() if category not in _FIXTURES}
    return RoomProgram(name, room.type, size, furniture, {}, fixtures, exact)


# -- what can be built instead ----------------------------------------------------------------------------------


def _nearest(wish: OwnHome, program: HomeProgram, room: str, category: str, thing: Thing, placed: int) -> str:
    """What can be built instead if furniture does not fit: a larger room, or fewer pieces."""
    for size in _larger(next(one.size_m for one in program.rooms if one.name == room)):
        rooms = tuple(replace(one, size_m=size) if one.name == room else one for one in program.rooms)
        larger = replace(program, rooms=rooms)
        if category not in _dropped(wish, larger).get(room, {}):
            sides = ", ".join(f"{side:g}" for side in size)
            what = "it" if thing.count == 1 else f"all {thing.count}"
            return f"there is room for {what} at size: [{sides}]" + (f"; else write {placed}" if placed else "")
    them = "it" if thing.count == 1 else "them"
    return f"write {placed}" if placed else f"leave {them} out, or put {them} into another room"


def _larger(size: tuple[float, float]) -> Iterator[tuple[float, float]]:
    for more in _ENLARGED_M:
        yield size[0] + more, size[1] + more


def _dropped(wish: OwnHome, program: HomeProgram) -> dict[str, dict[str, int]]:
    return build_program(own_name(wish.called, program, wish.seed), program, wish.seed).dropped
