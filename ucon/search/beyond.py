"""What lies beyond a view: the distances by which it is told."""

from __future__ import annotations

from typing import Final

#: R numbers of moves of 0.25 m from a view; what can be found within so many lies beyond it.
MOVES: Final = (3, 6, 12, 20, 32)
