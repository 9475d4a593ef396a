"""Who says where the target may be, given what was seen: what coverage and belief have in common."""

from __future__ import annotations

from typing import Protocol

from ucon.perception.places import Places
from ucon.perception.semantic_map import SemanticMap
from ucon.perception.viewpoints import Expectation


class Expecting(Protocol):
    """Says where the target may be, given what was seen."""

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Mass of tracks, unexplored space and space seen from afar."""
        ...

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Called before a view is chosen: read anew what depends on what was seen; True if that changed anything."""
        ...
