"""``python -m ucon home check FILE.yaml``: says what is built from a home file, what is not, and where things are."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.sim.house import House
    from ucon.task.own_home.building import Unplaced
    from ucon.task.own_home.placed import Placed
    from ucon.task.own_home.wish import OwnHome

#: Categories that are left out where a room is described in words.
_OF_EVERY_ROOM = ("window", "electric_switch", "room_light", "door")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE.yaml",
        help="home file; `home new FILE.yaml` writes one, and robot_flat is shipped",
    )
    parser.add_argument("--plan", type=Path, metavar="FILE.png", help="draw the floor plan into a picture")
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="draw the home, and what a camera sees of each room"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Build the home, place its requests, and print both.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        UconError: with every fault of the file, each with its line.
    """
    from ucon.core.errors import DataError, UconError
    from ucon.core.files import require_writable
    from ucon.core.output import stdout_to_stderr
    from ucon.envs.own_home import read_places
    from ucon.task.own_home.building import build, unplaced
    from ucon.task.own_home.placing import placed_requests
    from ucon.task.own_home.reading import raise_in_order, read_as_far
    from ucon.task.own_home.shipped import home_path
    from ucon.task.rules import PAPER

    for picture in (args.plan, args.picture):
        if picture is not None:
            require_writable(picture)
    file = home_path(args.file)
    with stdout_to_stderr():
        wish, faults = read_as_far(file)
        try:
            name, house = build(wish)
        except UconError as error:
            if faults.found:
                faults.found.append(str(error))
                raise_in_order(faults, file)
            raise
        missing = unplaced(wish, house)
        if args.plan is not None:
            _draw(house, args.plan)
        try:
            asked = wish.requests or faults.found
            placed = placed_requests(wish, name, house, read_places, PAPER, faults=faults)[0] if asked else ()
        except DataError:
            _warn(missing)
            raise
    if args.picture is not None:
        _picture(wish, house, placed, args.picture)
    found = _found(wish, name, house, placed) | {"not placed": [str(one) for one in missing]}
    if args.json:
        print(json.dumps(found, indent=1))
        return 0
    for line in _lines(found):
        print(line)
    sys.stdout.flush()
    _warn(missing)
    if placed:
        print(f"\nTo search it: python eval.py agent=belief habit_level=retrieval episodes={args.file}")
    return 0


def _warn(missing: list[Unplaced]) -> None:
    for one in missing:
        print(f"warning: {one}", file=sys.stderr)


def _found(wish: OwnHome, name: str, house: House, placed: tuple[Placed, ...]) -> dict[str, Any]:
    """Rooms, furniture, doors and placed requests of the built home, as plain values."""
    from ucon.task.own_home.building import rooms_by_name

    spec, called = house.spec, rooms_by_name(wish, house)
    rooms: list[dict[str, Any]] = [
        {
            "room": called[room.name],
            "type": room.type,
            "size_m": [round(room.rect[2] - room.rect[0], 2), round(room.rect[3] - room.rect[1], 2)],
            "furniture": dict(sorted(Counter(item.category for item in spec.items if item.room == k).items())),
        }
        for k, room in enumerate(spec.rooms)
    ]
    doors = [[called[spec.rooms[o.room_a].name], called[spec.rooms[o.room_b].name]] for o in spec.openings]
    return {
        "home": wish.called,
        "name": name,
        "kind": spec.kind,
        "area_m2": round(spec.area_m2, 1),
        "rooms": rooms,
        "doors": doors,
        "requests": [_request(one, [room["room"] for room in rooms]) for one in placed],
    }


def _request(one: Placed, rooms: list[str]) -> dict[str, Any]:
    from ucon.task.own_home.places import spoken
    from ucon.task.spoken import spoken_place

    said = " or ".join(spoken(place) for place in one.request.places)
    return {
        "target": one.request.target,
        "place": said or spoken_place(one.place.relation, one.place.anchor),
        "room": rooms[one.episodes[0].target_object.room],
        "chance_by_habits": None if one.chance is None else round(one.chance, 3),
        "shortest_path_m": [episode.shortest_path_m for episode in one.episodes],
        "habits": [habit.text for habit in one.request.habits],
    }


def _lines(found: dict[str, Any]) -> Iterator[str]:
    """The findings in words."""
    yield f"{found['home']}: a {found['kind']} of {found['area_m2']:g} m2, named {found['name']}"
    for room in found["rooms"]:
        things = ", ".join(_counted(one, n) for one, n in room["furniture"].items() if one not in _OF_EVERY_ROOM)
        width, length = room["size_m"]
        yield f"  {room['room']}, {width:g} x {length:g} m: {things}"
    if found["doors"]:
        yield "  doors: " + ", ".join(" - ".join(door) for door in found["doors"])
    for one in found["requests"]:
        chance = one["chance_by_habits"]
        name = one["target"].replace("_", " ")
        read = (
            ""
            if chance is None
            else f", as read from your habits ({100 * chance:.0f} %; if wrong, add `{name}: PLACE`)"
        )
        ways = ", ".join(f"{length:g}" for length in one["shortest_path_m"])
        yield f"{name}: {one['place']} in the {one['room']}{read}; shortest path {ways} m"
        yield from (f'  "{text}"' for text in one["habits"])


def _counted(category: str, n: int) -> str:
    name = category.replace("_", " ")
    return name if n == 1 else f"{n} x {name}"


def _draw(house: House, path: Path) -> None:
    from PIL import Image

    from ucon.core.output import say_written
    from ucon.scenes.plan import draw_plan

    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(draw_plan(house.spec)).save(path, format="png")
    say_written(path, "the floor plan")


def _picture(wish: OwnHome, house: House, placed: Sequence[Placed], path: Path) -> None:
    from ucon.core.output import say_written
    from ucon.evaluation.figures.home_picture import draw_home
    from ucon.sim.arrangement import Arrangement
    from ucon.task.own_home.building import rooms_by_name

    arrangement = placed[0].episodes[0].arrangement if placed else Arrangement()
    names = tuple(rooms_by_name(wish, house).values())
    draw_home(house, arrangement, names, f"{wish.called}, {house.spec.area_m2:.0f} m2", path)
    say_written(path, "the home")
