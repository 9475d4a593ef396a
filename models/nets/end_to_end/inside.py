"""Intermediate results of the end-to-end habit policy, from which its actions are explained."""

from __future__ import annotations

from typing import NamedTuple

from models.nets.end_to_end.places_to_go import Ways
from models.nets.end_to_end.things_in_view import Seen


class PolicyTrace(NamedTuple):
    """Intermediate results for T steps of B episodes.

    :mod:`models.nets.end_to_end.reasons` explains actions from them.
    """

    seen: Seen
    ways: Ways
    """Places to go to."""
