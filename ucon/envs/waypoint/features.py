"""Candidates as numbers: what a policy over ``UcONWaypoint-v0`` sees of its choices."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.perception.candidates import KINDS, Candidate
from ucon.perception.semantic_map import View

#: Columns of the features of a candidate after the one-hot of its kind.
COLUMNS = ("ahead_m", "left_m", "cost", "cells", "unseen", "free_m", "n_things")
N_FEATURES = len(KINDS) + len(COLUMNS)
N_THINGS = 8
"""Categories listed for a candidate: the thing itself, or the largest of what is seen there."""


@cache
def category_rows() -> dict[str, int]:
    """Row of every category of the catalogue, in its order: what ``candidate_things`` numbers."""
    return {name: row for row, name in enumerate(catalogue().names)}


def features(candidates: Sequence[Candidate], view: View, most: int) -> NDArray[np.float32]:
    """(most, N_FEATURES) float32, zero rows where there is no candidate; positions in the agent's present frame."""
    out = np.zeros((most, N_FEATURES), np.float32)
    c, s = (1, 0, -1, 0)[view.heading], (0, 1, 0, -1)[view.heading]
    x, y = view.xy
    for row, candidate in zip(out, candidates, strict=False):
        dx, dy = candidate.view.xy[0] - x, candidate.view.xy[1] - y
        row[KINDS.index(candidate.kind)] = 1.0
        row[len(KINDS) :] = (
            c * dx + s * dy, c * dy - s * dx, candidate.cost, candidate.cells, candidate.unseen, candidate.free_m,
            len(candidate.things),
        )  # fmt: skip
    return out


def things(candidates: Sequence[Candidate], most: int) -> NDArray[np.int32]:
    """(most, N_THINGS) int32 rows of the catalogue, -1 where there is nothing; unknown names are left out."""
    rows = category_rows()
    out = np.full((most, N_THINGS), -1, np.int32)
    for row, candidate in zip(out, candidates, strict=False):
        names = [candidate.category] if candidate.category else [name for name, _ in candidate.things]
        known = [rows[name] for name in names if name in rows][:N_THINGS]
        row[: len(known)] = known
    return out
