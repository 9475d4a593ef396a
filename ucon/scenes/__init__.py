"""Homes: the 22 official scenes as procedural analogues, their variants, and any number of generated ones.

Names are imported when they are first used (:mod:`ucon.core.lazy`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ucon.core.lazy import lazy_names

if TYPE_CHECKING:
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

__getattr__ = lazy_names(
    __name__,
    {
        "ucon.scenes.library": ("SCENES", "UNSEEN_SCENES", "built_home", "home_spec", "scene_split"),
        "ucon.scenes.spec": ("GRID_M", "HomeSpec", "Item", "Opening", "Room"),
    },
)
