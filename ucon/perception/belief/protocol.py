"""Who says where the target may be, given what was seen: what coverage and belief have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

if TYPE_CHECKING:
    from ucon.perception.belief.target_belief import Locations


class Expecting(Protocol):
    """Says where the target may be, given what was seen."""

    @property
    def locations(self) -> Locations | None:
        """What the habits were read to say; None for who reads nothing."""
        ...

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Mass of tracks, unexplored space and space seen from afar."""
        ...

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Called before a view is chosen: read anew what depends on what was seen; True if that changed anything."""
        ...
