"""Placement of objects in the four relations, settled by PyBullet and checked by predicates; import of anchors."""

from ucon.sim.placement.importing import import_anchor, importable
from ucon.sim.placement.place import place, with_object
from ucon.sim.placement.plausible import implausible
from ucon.sim.placement.reasons import REASONS, Reason, RefusedError

__all__ = ["REASONS", "Reason", "RefusedError", "implausible", "import_anchor", "importable", "place", "with_object"]
