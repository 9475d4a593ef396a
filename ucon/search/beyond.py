"""Distances from a view within which the policy foresees what can be found."""

from __future__ import annotations

from typing import Final

#: R numbers of moves of 0.25 m from a view; what can be found within so many lies beyond it.
MOVES: Final = (3, 6, 12, 20, 32)
