"""The simulator: PyBullet worlds, compiled homes, placement, renderers, shortest paths.

Names are imported when they are first used (:mod:`ucon.core.lazy`). Importing this
package does not import PyBullet; building a home or placing an object does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ucon.core.lazy import lazy_names

if TYPE_CHECKING:
    from ucon.sim.arrangement import Arrangement, PlacedObject
    from ucon.sim.cache import load_house
    from ucon.sim.house import House, NavGrid
    from ucon.sim.state import SceneState, arrangement_boxes

__all__ = ["Arrangement", "House", "NavGrid", "PlacedObject", "SceneState", "arrangement_boxes", "load_house"]

__getattr__ = lazy_names(
    __name__,
    {
        "ucon.sim.arrangement": ("Arrangement", "PlacedObject"),
        "ucon.sim.cache": ("load_house",),
        "ucon.sim.house": ("House", "NavGrid"),
        "ucon.sim.state": ("SceneState", "arrangement_boxes"),
    },
)
