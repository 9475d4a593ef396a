"""Interface of readers of habits: the fitted :class:`ucon.readers.anchor_reader.AnchorReader`, or a trained one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.habits.contexts import Context


class Belief(Protocol):
    """Distribution over C candidate anchors."""

    @property
    def candidates(self) -> tuple[str, ...]:
        """Names of the C candidates."""
        ...

    @property
    def p(self) -> NDArray[np.float64]:
        """(C,) probability that the target is at each candidate."""
        ...

    @property
    def relation(self) -> NDArray[np.float64]:
        """(C, 4) p(relation | anchor)."""
        ...


class Read(Protocol):
    """What H habits say about a target."""

    @property
    def relevance(self) -> NDArray[np.float64]:
        """(H,) probability that each habit is about the target."""
        ...

    @property
    def telling(self) -> NDArray[np.float64]:
        """(H,) how much each habit says about where the target is, 0 to 1."""
        ...

    def belief(self, candidates: Sequence[str]) -> Belief:
        """Distribution over candidate anchors; may be called again with more of them."""
        ...

    def support(self, anchor: str) -> NDArray[np.float64]:
        """(H,) how strongly each habit speaks for the target being at ``anchor``."""
        ...


class Reader(Protocol):
    """Turns habits into a distribution over the target's anchors."""

    @property
    def known(self) -> Sequence[str]:
        """Anchors in its training data."""
        ...

    def read(self, target: str, texts: Sequence[str], *, trusted: bool = False, context: Context | None = None) -> Read:
        """Read the habits of an episode once.

        Args:
            target: category that is looked for.
            texts: the habits.
            trusted: True if all of them are about the target (level ``gt``).
            context: the context that was told; None: none was told.
        """
        ...


def read_info(reader: Reader, info: Mapping[str, Any]) -> Read:
    """Read the habits of an episode from the info of its reset.

    Args:
        reader: reads the habits.
        info: ``target``, ``habits``, ``habit_level`` (at ``gt`` all habits are about the target) and, where a context
            is told, ``told``.
    """
    told = info.get("told")
    more: dict[str, Any] = {} if told is None else {"context": told}
    return reader.read(str(info["target"]), tuple(info["habits"]), trusted=info.get("habit_level") == "gt", **more)
