"""The true free grid that an environment may give the planner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared


@dataclass(frozen=True, eq=False)
class Nav(Shared):
    """One home's grid. No plain dictionary: vector environments would pile the arrays up, and homes differ in shape."""

    free: NDArray[np.bool_]
    """(X, Y) nodes that can be stood on, turned to the agent's start frame."""
    start: tuple[int, int]
    """Cell of the start."""

    def __getitem__(self, name: str) -> Any:
        """``nav["free"]``, ``nav["start"]``, as in a mapping."""
        if name not in ("free", "start"):
            raise KeyError(name)
        return getattr(self, name)

    def __eq__(self, other: object) -> bool:
        """Whether all is equal: infos are compared to see that an environment repeats itself."""
        return isinstance(other, Nav) and self.start == other.start and np.array_equal(self.free, other.free)

    __hash__ = None  # type: ignore[assignment]  # arrays have none
