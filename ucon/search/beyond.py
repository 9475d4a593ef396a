"""Distances from a view for which the policy predicts what can be found."""

from __future__ import annotations

from typing import Final

#: The R distances, in moves of 0.25 m from a view; what can be found within each of them lies *beyond* the view.
MOVES: Final = (3, 6, 12, 20, 32)
