"""A searching agent's scores of views as labels: for every choice among views, the scores of the best ones."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.perception.mapping.semantic_map import View
from ucon.perception.views.viewpoints import ViewValues
from ucon.search.search_decision import SearchDecision, Seeking
from ucon.search.searcher import LOYALTY

N_VIEWS: Final = 256
"""Most views of a label: those with the best scores."""
BEST: Final = 10_000
"""Score of the best view of a label; those of the others are relative to it."""

Label = NDArray[np.int16]
"""(N_VIEWS, 4) int16: cells ahead and to the left of the agent, quarter turns to the left from its heading, and score.

Positions are relative to the agent, so the label stays the same however the map is turned. Rows of score 0 are empty.
"""


def no_views() -> Label:
    """An empty label."""
    return np.zeros((N_VIEWS, 4), np.int16)


def views_label(search: Seeking, decision: SearchDecision | None) -> Label:
    """The label of a step.

    Args:
        search: after its step.
        decision: what it chose from in this step; None where it had nothing to choose.

    Returns:
        The views by score, if it chose; the pose that it goes to, if it walks up to the target; else an empty label.
    """
    here = search.map.view
    if search.taking:
        return _one(here, search.homing.goal)
    if decision is None:
        return no_views()
    if decision.valued is None:
        return _one(here, None if decision.best is None else decision.best.view)
    return _many(here, decision.valued)


def _one(here: View, view: View | None) -> Label:
    label = no_views()
    if view is not None:
        label[0] = *_from(here, np.array([[view.i, view.j]]))[0], (view.heading - here.heading) % 4, BEST
    return label


def _many(here: View, valued: ViewValues) -> Label:
    """The best nodes and headings by the score of their best pitch; that of the view it is on its way to is raised."""
    score = valued.score.copy()
    if valued.kept_at[0] >= 0:
        score[valued.kept_at] *= LOYALTY
    score = score.max(2)  # (n, 4)
    order = np.argsort(-score, axis=None, kind="stable")[:N_VIEWS]
    node, heading = np.unravel_index(order, score.shape)
    relative = score[node, heading] / max(float(score.max()), 1e-12)
    label = no_views()
    rows = label[: len(order)]
    rows[:, :2] = _from(here, valued.nodes[node])
    rows[:, 2] = (heading - here.heading) % 4
    rows[:, 3] = np.rint(BEST * relative)
    return label


def _from(here: View, nodes: NDArray[np.integer]) -> NDArray[np.int64]:
    """Cells (n, 2) ahead and to the left of the agent."""
    di, dj = nodes[:, 0].astype(np.int64) - here.i, nodes[:, 1].astype(np.int64) - here.j
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[here.heading % 4]
    return np.stack([cos * di + sin * dj, cos * dj - sin * di], 1)
