"""The true grid of free nodes, which an environment may give to the planner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared


@dataclass(frozen=True, eq=False)
class Nav(Shared):
    """One home's grid of free nodes, in the agent's start frame.

    It is not a plain dictionary, since vector environments would stack the arrays, whose shapes differ between homes.
    """

    free: NDArray[np.bool_]
    """(X, Y) True at nodes that can be stood on; axes as in the agent's start frame."""
    start: tuple[int, int]
    """Row and column of the start in ``free``."""

    def __getitem__(self, name: str) -> Any:
        """``nav["free"]``, ``nav["start"]``, as in a mapping."""
        if name not in ("free", "start"):
            raise KeyError(name)
        return getattr(self, name)

    def __eq__(self, other: object) -> bool:
        """Whether grids and starts are equal; used to check that an environment repeats itself."""
        return isinstance(other, Nav) and self.start == other.start and np.array_equal(self.free, other.free)

    __hash__ = None  # type: ignore[assignment]  # arrays have none
