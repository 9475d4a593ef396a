"""Weights of the sentences given to an agent: how far its belief moves if the sentence is left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ucon.perception.belief.target_belief import Locations

#: Reads the habits of an info, as :data:`ucon.perception.belief.from_habits.Locate`.
Locate = Callable[[dict[str, Any]], Locations]


@dataclass(frozen=True)
class Weighed:
    """One sentence that is given in an episode, with its weight."""

    rank: int
    """Its place in the list that the agent is given, from 1."""
    row: int
    """Its row in the dataset."""
    habit: str
    weight: float
    """Total variation distance between the belief with it and without it, 0 to 1."""


def weighed(target: str, level: str, rows: Sequence[int], habits: Sequence[str], locate: Locate) -> list[Weighed]:
    """The sentences that move the belief at all, the weightiest first.

    Args:
        target: category that is searched for.
        level: habit level at which they are given.
        rows: (n,) their rows in the dataset.
        habits: the n sentences.
        locate: reads them.
    """

    def read(told: Sequence[str]) -> Locations:
        return locate({"target": target, "habits": tuple(told), "habit_level": level})

    whole, found = read(habits), []
    for k, (row, habit) in enumerate(zip(rows, habits, strict=True)):
        weight = moved(whole, read([*habits[:k], *habits[k + 1 :]]))
        if weight > 0.0:
            found.append(Weighed(k + 1, int(row), habit, weight))
    return sorted(found, key=lambda one: (-one.weight, one.rank))


def moved(first: Locations, second: Locations) -> float:
    """Total variation distance of two beliefs, 0 to 1, rounded to 1e-6; the mass at no named anchor counts as a place.

    Args:
        first: a belief over A anchors.
        second: a belief over other or the same anchors.
    """
    rows = [dict(zip(one.names, one.p, strict=True)) for one in (first, second)]
    none = np.zeros(first.p.shape[1])
    apart = sum(np.abs(rows[0].get(name, none) - rows[1].get(name, none)).sum() for name in rows[0].keys() | rows[1])
    rest = abs(float(first.p.sum()) - float(second.p.sum()))
    return round(0.5 * (float(apart) + rest), 6)
