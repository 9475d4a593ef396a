"""Decisions as arrays, as the network sees them, with labels; text is kept once an episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.search.searcher import LOYALTY
from ucon.search.view_tokens import IS_KEPT, RIVAL

Arrays = dict[str, NDArray[Any]]
#: Entries of an observation that are text, the same in all decisions of an episode.
TEXT: Final = ("target", "habits", "habits_relevance", "habits_mask")
#: Smallest type that holds each kind of array; all others are float16.
_TYPES: Final = {"map": np.uint8, "thing_rows": np.int16, "action_mask": np.uint8, "things_mask": np.uint8,
                 "frontiers_mask": np.uint8, "habits_mask": np.uint8, "worth": np.float32}  # fmt: skip


@dataclass(frozen=True)
class Decisions:
    """n decisions of m episodes."""

    frames: Arrays
    """Observations of ``UcONSearch-v0`` without text, and labels, (n, ...) by name; floats as float16."""
    text: Arrays
    """Text of the episodes, (m, ...) by name; see :data:`TEXT`."""
    episode: NDArray[np.int32]
    """(n,) row of each decision's episode in ``text``."""

    @classmethod
    def join(cls, parts: Sequence[Decisions]) -> Decisions:
        """Join the decisions of several parts."""
        first = np.cumsum([0, *(len(next(iter(part.text.values()))) for part in parts[:-1])])
        frames = {name: np.concatenate([part.frames[name] for part in parts]) for name in parts[0].frames}
        text = {name: np.concatenate([part.text[name] for part in parts]) for name in parts[0].text}
        rows = [part.episode + start for part, start in zip(parts, first, strict=True)]
        return cls(frames, text, np.concatenate(rows).astype(np.int32))

    def __len__(self) -> int:
        return len(self.episode)


def joined(kept: Sequence[Arrays], text: Arrays) -> Decisions | None:
    """Decisions of one episode.

    Args:
        kept: observations of the decisions, without text, and their labels.
        text: of the episode, by name.

    Returns:
        None where there is no decision.
    """
    if not kept:
        return None
    frames = {name: small(name, np.stack([row[name] for row in kept])) for name in kept[0]}
    return Decisions(frames, {name: small(name, text[name][None]) for name in TEXT}, np.zeros(len(kept), np.int32))


def by_gain_over_cost(observation: Arrays) -> int:
    """Row of the view with most gain over cost, as :mod:`ucon.search.searcher` chooses it."""
    return int(first_views(observation))


def first_views(frames: Arrays) -> NDArray[np.int64]:
    """Row of the view with most gain over cost in each of some decisions.

    Args:
        frames: ``prior`` (..., V), ``views`` (..., V, N_VIEW) and ``action_mask`` (..., V).

    Returns:
        (...,) int64.
    """
    return np.asarray(_scores(frames).argmax(-1))


def rivals(frames: Arrays) -> NDArray[np.bool_]:
    """Views with nearly as much gain over cost as the first of their decision, which is among them.

    Args:
        frames: see :func:`first_views`.

    Returns:
        (..., V) bool.
    """
    scores = _scores(frames)
    return np.asarray(scores > scores.max(-1, keepdims=True) - RIVAL)


def _scores(frames: Arrays) -> NDArray[Any]:
    """Log gain over cost with the bonus of the view that is kept, -inf where there is no view."""
    score = frames["prior"] + np.log(LOYALTY) * frames["views"][..., IS_KEPT]
    return np.asarray(np.where(frames["action_mask"] > 0, score, -np.inf))


def small(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Values in the smallest type that holds them."""
    return np.ascontiguousarray(values.astype(_TYPES.get(name, np.float16)))
