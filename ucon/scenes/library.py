"""Homes by name: the 22 official scenes, their variants, and generated homes."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Literal

from ucon.core.errors import SceneError, unknown_name
from ucon.core.rng import derived_seed
from ucon.scenes.home import BuiltHome, build_home, build_program
from ucon.scenes.own import is_own, own_program
from ucon.scenes.procedural import procedural_program
from ucon.scenes.program import HOME_KINDS, scene_programs
from ucon.scenes.spec import HomeSpec

SCENES: tuple[str, ...] = tuple(scene_programs())
UNSEEN_SCENES = ("Beechwood_1_int", "Pomaria_1_int")
UNSEEN_SEED = 900_000
"""First seed of the generated homes that are reserved for tests of unseen homes."""
MAX_SEED = 10**9


@lru_cache(maxsize=64)
def built_home(name: str) -> BuiltHome:
    """A home and the items that found no place.

    Args:
        name: ``Rs_int``, ``Rs_int~3`` (variant 3), ``procedural:house:17``, or that of an own home.

    Raises:
        SceneError: no such home; the message names the nearest ones.
        DataError: an own home that is not stored here.
    """
    if is_own(name):
        return build_program(name, *own_program(name))
    if name.startswith("procedural"):
        kind, seed = parse_procedural(name)
        return build_home(name, procedural_program(kind, seed), derived_seed(seed, "procedural", kind))
    scene, variant = parse_scene(name)
    return build_home(name, scene_programs()[scene], derived_seed(variant, "scene", scene))


def home_spec(name: str) -> HomeSpec:
    """The specification of a home.

    Args:
        name: see :func:`built_home`.

    Raises:
        SceneError: no such home; the message names the nearest ones.
        DataError: an own home that is not stored here.
    """
    return built_home(name).spec


def is_home_name(name: str) -> bool:
    """Whether a name has the form of an official, generated or own home's; see :func:`check_home_name`."""
    return name.startswith("procedural:") or is_own(name) or name.partition("~")[0] in SCENES


def check_home_name(name: str) -> None:
    """Check that a home of this name exists, without building it.

    Raises:
        SceneError: no such home; the message names the nearest ones.
        DataError: an own home that is not stored here.
    """
    if is_own(name):
        own_program(name)
    elif name.startswith("procedural"):
        parse_procedural(name)
    else:
        parse_scene(name)


def scene_split(name: str) -> Literal["seen", "unseen"]:
    """Whether a home may be trained on (``seen``) or is reserved for tests (``unseen``), as own homes are."""
    if is_own(name):
        return "unseen"
    if name.startswith("procedural"):
        return "unseen" if parse_procedural(name)[1] >= UNSEEN_SEED else "seen"
    return "unseen" if parse_scene(name)[0] in UNSEEN_SCENES else "seen"


def parse_scene(name: str) -> tuple[str, int]:
    """Scene and variant of a name such as ``Rs_int~3``; variant 0 is the canonical home.

    Raises:
        SceneError: no such scene, or no such variant.
    """
    scene, mark, variant = name.partition("~")
    if scene not in SCENES:
        raise SceneError(unknown_name("scene", name, SCENES, remedy="Generated homes: procedural:<kind>:<seed>."))
    if not mark:
        return scene, 0
    if not re.fullmatch(r"[1-9][0-9]{0,8}", variant):
        raise SceneError(f"scene '{name}': variant '{variant}', expected a whole number from 1, as in {scene}~3")
    return scene, int(variant)


def parse_procedural(name: str) -> tuple[str, int]:
    """Kind and seed of a name such as ``procedural:house:17``.

    Raises:
        SceneError: no such kind, or no such seed.
    """
    parts = name.split(":")
    if len(parts) != 3 or parts[0] != "procedural":
        raise SceneError(f"scene '{name}': expected procedural:<kind>:<seed>, as in procedural:house:17")
    _, kind, seed = parts
    if kind not in HOME_KINDS:
        raise SceneError(f"scene '{name}': {unknown_name('kind', kind, HOME_KINDS)}")
    if not re.fullmatch(r"0|[1-9][0-9]{0,9}", seed) or int(seed) > MAX_SEED:
        raise SceneError(f"scene '{name}': seed '{seed}', expected a whole number from 0 to {MAX_SEED}")
    return kind, int(seed)
