"""What a reader of habits is: the fitted :class:`ucon.readers.anchor_reader.AnchorReader`, or a trained one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Belief(Protocol):
    """What a reading makes of candidate anchors."""

    @property
    def candidates(self) -> tuple[str, ...]:
        """The C candidates."""
        ...

    @property
    def p(self) -> NDArray[np.float64]:
        """(C,) probability that the target is by each."""
        ...

    @property
    def relation(self) -> NDArray[np.float64]:
        """(C, 4) relation to it, given that."""
        ...


class Read(Protocol):
    """What a reader makes of some habits."""

    @property
    def relevance(self) -> NDArray[np.float64]:
        """(H,) how much each habit is about the target."""
        ...

    @property
    def telling(self) -> NDArray[np.float64]:
        """(H,) how much each habit is taken to say where the target is."""
        ...

    def belief(self, candidates: Sequence[str]) -> Belief:
        """Belief over candidate anchors."""
        ...

    def support(self, anchor: str) -> NDArray[np.float64]:
        """(H,) how strongly each habit speaks for the target being by ``anchor``."""
        ...


class Reader(Protocol):
    """Reads habits."""

    @property
    def known(self) -> Sequence[str]:
        """Anchors that it was fitted on."""
        ...

    def read(self, target: str, texts: Sequence[str], *, trusted: bool = False) -> Read:
        """Read the habits of an episode once."""
        ...
