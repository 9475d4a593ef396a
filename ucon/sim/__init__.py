"""The simulator: PyBullet worlds, compiled homes, placement, renderers, shortest paths.

Importing this package does not import PyBullet; building a home or placing an object does.
"""

from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.cache import load_house
from ucon.sim.house import House, NavGrid
from ucon.sim.state import SceneState, arrangement_boxes

__all__ = ["Arrangement", "House", "NavGrid", "PlacedObject", "SceneState", "arrangement_boxes", "load_house"]
