"""Homes: the 22 official scenes as procedural analogues, their variants, and generated ones without limit."""

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
