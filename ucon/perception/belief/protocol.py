"""The interface that coverage and belief share: where is the target, given what was seen?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

if TYPE_CHECKING:
    from ucon.perception.belief.target_belief import Locations


class Expecting(Protocol):
    """Expected target mass on the map of one episode, updated as the map grows."""

    @property
    def locations(self) -> Locations | None:
        """The distribution over anchor and relation that was read from the habits; None for models that read none."""
        ...

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Expected mass, given the map so far.

        Args:
            known: the map, with T tracks.
            places: sample points on the map, with what was seen of each.

        Returns:
            Mass (T, 4) of tracks and relations, of unexplored space, and of space seen from too far away.
        """
        ...

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Update what depends on what was seen; called before a view is chosen.

        Returns:
            Whether anything changed, so that :meth:`expect` must be called again.
        """
        ...
