"""Room programs: the rooms of a home, their sizes, their content, and which are joined.

The 22 official scenes come from measured inventories (``data/programs.json``, credited in ``docs/DATA.md``); generated
homes get theirs from :mod:`ucon.scenes.procedural`. Layout and furnishing use nothing else.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from typing import Any

from ucon.core.errors import DataError

JOINTS = ("doorway", "opening_1.2", "opening_1.5", "opening_2.0", "open")
HOME_KINDS = ("house", "flat", "office", "restaurant", "shop")
_SOURCE = "ucon/scenes/data/programs.json"
_REINSTALL = f" in {_SOURCE}; reinstall the package"


@dataclass(frozen=True)
class RoomProgram:
    """One room of a program: what it should be and hold."""

    name: str
    type: str
    size_m: tuple[float, float]
    """Width and length, in either order."""
    furniture: Mapping[str, int] = field(default_factory=dict)
    """Number of items by category."""
    surface: Mapping[str, int] = field(default_factory=dict)
    """Number of small things that stand on furniture, by category."""
    fixtures: Mapping[str, int] = field(default_factory=dict)
    """Number of windows, switches and lights, by category."""
    exact: bool = False
    """Whether the size is kept: other rooms grow by up to 1 m where that closes a gap."""


@dataclass(frozen=True)
class HomeProgram:
    """Rooms and the openings between them, a tree with the root ``hub``."""

    kind: str
    wall_height_m: float
    hub: str
    rooms: tuple[RoomProgram, ...]
    edges: tuple[tuple[str, str, str], ...]
    """(room nearer the hub, room, kind of opening): ``doorway``, ``opening_<width>`` or ``open``."""


@dataclass(frozen=True)
class TypeStats:
    """Statistics of the measured rooms of one type."""

    area_m2: tuple[float, float, float]
    """Median, smallest and largest area."""
    categories: tuple[tuple[str, float, float], ...]
    """(category, share of rooms that have it, mean number where present)."""


@lru_cache(maxsize=1)
def scene_programs() -> dict[str, HomeProgram]:
    """Programs of the official scenes, by name; sorted.

    Raises:
        DataError: the shipped file cannot be read.
    """
    scenes = _section("scenes")
    return {name: program_of(name, scenes[name], _REINSTALL) for name in sorted(scenes)}


@lru_cache(maxsize=1)
def type_stats() -> dict[str, TypeStats]:
    """Statistics of the measured rooms, by room type; sorted.

    Raises:
        DataError: the shipped file cannot be read.
    """
    types = _section("room_types")
    stats = {}
    for name in sorted(types):
        try:
            row = types[name]
            area = tuple(float(row[f"area_{k}_m2"] or 4.0) for k in ("median", "min", "max"))
            rows = tuple((str(c), float(p), float(n)) for c, p, n in row["categories"])
        except (KeyError, TypeError, ValueError) as error:
            raise DataError(f"{_SOURCE}: room type '{name}' is malformed ({error}); reinstall the package") from None
        stats[name] = TypeStats((area[0], area[1], area[2]), rows)
    return stats


def _section(key: str) -> dict[str, Any]:
    try:
        return dict(json.loads(files("ucon.scenes").joinpath("data/programs.json").read_text("utf-8"))[key])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"{_SOURCE}: cannot be read ({error}); reinstall the package") from None


def program_of(name: str, raw: Any, remedy: str = "") -> HomeProgram:
    """A program from JSON data.

    Args:
        name: of the home, for errors.
        raw: the data.
        remedy: added to the error about malformed data.

    Raises:
        DataError: it is malformed, or :func:`check_program` refuses it.
    """
    try:
        rooms = tuple(
            RoomProgram(
                str(r["name"]),
                str(r["type"]),
                (float(r["size_m"][0]), float(r["size_m"][1])),
                dict(r["furniture"]),
                dict(r["surface"]),
                dict(r["fixtures"]),
                r.get("exact") is True,
            )
            for r in raw["rooms"]
        )
        edges = tuple((str(a), str(b), str(k)) for a, b, k in raw["edges"])
        program = HomeProgram(str(raw["kind"]), float(raw["wall_height_m"]), str(raw["hub"]), rooms, edges)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise DataError(f"scene '{name}' is malformed ({error}){remedy}") from None
    check_program(name, program)
    return program


def check_program(name: str, program: HomeProgram) -> None:
    """Check a program: known kinds, unique names, plausible sizes, and edges that form a tree from the hub.

    Args:
        name: of the home, for errors.
        program: what to check.

    Raises:
        DataError: naming the first fault.
    """
    names = {r.name for r in program.rooms}
    reached = {program.hub}
    for parent, child, joint in program.edges:
        if joint not in JOINTS:
            raise DataError(f"scene '{name}': joint '{joint}' of {parent}-{child}, expected one of {', '.join(JOINTS)}")
        reached.add(child)
    problem = ""
    if program.kind not in HOME_KINDS:
        problem = f"kind '{program.kind}', expected one of {', '.join(HOME_KINDS)}"
    elif len(names) != len(program.rooms):
        problem = "two rooms share a name"
    elif reached != names or len(program.edges) != len(names) - 1:
        problem = f"edges must join every room once to the hub; check {', '.join(sorted(reached ^ names)) or 'loops'}"
    elif not all(1.0 <= side <= 40.0 for r in program.rooms for side in r.size_m):
        problem = "a room side outside 1 to 40 m"
    elif not all(n > 0 for r in program.rooms for m in (r.furniture, r.surface, r.fixtures) for n in m.values()):
        problem = "a count below 1"
    if problem:
        raise DataError(f"scene '{name}': {problem}")
