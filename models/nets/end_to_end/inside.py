"""What the end-to-end habit policy thought on the way to its action."""

from __future__ import annotations

from typing import NamedTuple

from models.nets.end_to_end.places_to_go import Ways
from models.nets.end_to_end.things_in_view import Seen


class Inside(NamedTuple):
    """What the network thought on the way, for T steps of B episodes: see :mod:`models.nets.end_to_end.reasons`."""

    seen: Seen
    ways: Ways
    """Of T * B agents."""
