"""Homes: procedural analogues of the 22 official scenes, their variants, and generated homes."""

from ucon.scenes.library import SCENES, UNSEEN_SCENES, built_home, home_spec, scene_split
from ucon.scenes.spec import GRID_M, HomeSpec, Item, Opening, Room

__all__ = [
    "GRID_M",
    "SCENES",
    "UNSEEN_SCENES",
    "HomeSpec",
    "Item",
    "Opening",
    "Room",
    "built_home",
    "home_spec",
    "scene_split",
]
