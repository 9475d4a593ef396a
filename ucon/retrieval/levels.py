"""Habit levels: how much of the knowledge base an agent is given. Four are the paper's; ``context`` is an addition."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, unknown_name
from ucon.habits.knowledge import KnowledgeBase
from ucon.retrieval.base import Retriever

Level = Literal["none", "full", "gt", "retrieval", "context"]
#: Levels of the paper; the list does not change during an episode.
FIXED_LEVELS: tuple[Level, ...] = ("none", "full", "gt", "retrieval")
#: Levels whose habits are ranked, so that recall and reciprocal rank are defined.
RANKED_LEVELS: tuple[Level, ...] = ("retrieval", "context")
LEVELS: tuple[Level, ...] = (*FIXED_LEVELS, "context")
TOP_P = 20


def check_level(level: str) -> None:
    """Raise :class:`ConfigError` for an unknown habit level."""
    if level not in LEVELS:
        raise ConfigError(unknown_name("habit level", level, LEVELS))


def habits_at_level(
    level: str, kb: KnowledgeBase, target: str, retriever: Retriever | None = None, p: int = TOP_P
) -> NDArray[np.int32]:
    """Rows of the dataset that an agent is given.

    ``none``: nothing; ``full``: all, in the order of the knowledge base; ``gt``: every habit about the target, whether
    it supports a placement or not; ``retrieval``: the ``p`` best of the retriever, best first; ``context``: the same at
    the start, then re-ranked by what is seen (:class:`ucon.retrieval.context.ContextHabits`).

    Args:
        level: habit level.
        kb: the knowledge base.
        target: category that is looked for.
        retriever: for the levels that rank.
        p: number of retrieved habits.

    Returns:
        Row numbers, int32.

    Raises:
        ConfigError: unknown level or target, ``p`` < 1, or no retriever for a level that ranks.
    """
    check_level(level)
    if level == "none":
        return np.empty(0, np.int32)
    if level == "full":
        return kb.rows
    if level == "gt":
        return kb.rows_about(target)
    if retriever is None:
        raise ConfigError(f"habit level '{level}' without a retriever; give one, for example DenseRetriever()")
    if p < 1:
        raise ConfigError(f"retrieval of p={p} habits, expected at least 1")
    return retriever.rank(target, kb)[:p]
