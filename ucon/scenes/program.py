"""Room programs: which rooms a home has, how large, what stands in them and which are joined.

The 22 official scenes come from measured inventories (``data/programs.json``, credited in ``docs/DATA.md``);
generated homes get theirs from :mod:`ucon.scenes.procedural`. Layout and furnishing read nothing else.
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


@dataclass(frozen=True)
class RoomProgram:
    """One room as it is wished for: ``size_m`` is width and length in either order."""

    name: str
    type: str
    size_m: tuple[float, float]
    furniture: Mapping[str, int] = field(default_factory=dict)
    surface: Mapping[str, int] = field(default_factory=dict)
    """Small things that stand on furniture."""
    fixtures: Mapping[str, int] = field(default_factory=dict)
    """Windows, switches and lights."""


@dataclass(frozen=True)
class HomeProgram:
    """Rooms and the openings between them, a tree rooted at ``hub``."""

    kind: str
    wall_height_m: float
    hub: str
    rooms: tuple[RoomProgram, ...]
    edges: tuple[tuple[str, str, str], ...]
    """(room nearer the hub, room, kind of joint): ``doorway``, ``opening_<width>``, ``open``."""


@dataclass(frozen=True)
class TypeStats:
    """What rooms of one type hold: (category, share of rooms that have it, mean number where present)."""

    area_m2: tuple[float, float, float]
    """Median, smallest, largest."""
    categories: tuple[tuple[str, float, float], ...]


@lru_cache(maxsize=1)
def scene_programs() -> dict[str, HomeProgram]:
    """Programs of the official scenes by name, sorted."""
    scenes = _section("scenes")
    return {name: _program(name, scenes[name]) for name in sorted(scenes)}


@lru_cache(maxsize=1)
def type_stats() -> dict[str, TypeStats]:
    """Statistics of room types by name, sorted."""
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


def _program(name: str, raw: Any) -> HomeProgram:
    try:
        rooms = tuple(
            RoomProgram(
                str(r["name"]),
                str(r["type"]),
                (float(r["size_m"][0]), float(r["size_m"][1])),
                dict(r["furniture"]),
                dict(r["surface"]),
                dict(r["fixtures"]),
            )
            for r in raw["rooms"]
        )
        edges = tuple((str(a), str(b), str(k)) for a, b, k in raw["edges"])
        program = HomeProgram(str(raw["kind"]), float(raw["wall_height_m"]), str(raw["hub"]), rooms, edges)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise DataError(f"{_SOURCE}: scene '{name}' is malformed ({error}); reinstall the package") from None
    check_program(name, program)
    return program


def check_program(name: str, program: HomeProgram) -> None:
    """Raise DataError unless kinds are known, names unique, sizes sane and the edges form a tree from the hub."""
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
