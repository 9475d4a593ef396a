"""Candidate views as rows of numbers: gain, cost, position, and the mass and unexplored space around each."""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View
from ucon.perception.views.view_kernels import PITCHES_DEG
from ucon.perception.views.viewpoints import Choice, ViewValues

F32 = NDArray[np.float32]
#: Radii in metres around a view within which mass and unexplored space are summed.
RADII_M: Final = (1.0, 2.0, 4.0)
_PLAIN: Final = 15
#: Columns of the position ahead and to the left, in units of 5 m.
AHEAD: Final = slice(10, 12)
#: Column that is 1 for the view that the agent is on its way to.
IS_KEPT: Final = 9
#: Views whose log gain over cost is less than this below the best are its rivals. In rollouts of 340 decisions, views
#: up to .7 below were worth as much as the best (+.0005 +- .0008 SPL), and views 1.1 to 1.5 below were worth .005 less.
RIVAL: Final = 1.0
#: Column that is 1 where the agent stood at the node.
VISITED: Final = 14
#: Column of the moves to a view: the square root of their number divided by 40.
_MOVES: Final = 6
_MOVES_UNIT: Final = 40.0
#: Columns of a view token.
N_VIEW: Final = _PLAIN + 4 + len(PITCHES_DEG) + 2 * len(RADII_M)


def log_scale(x: Any) -> Any:
    """Masses and scores on a logarithmic scale, since they span decades: 0 for 1e-4 or less, 1 for about 1.

    Args:
        x: a number or an array.
    """
    return np.log10(np.maximum(x, 0.0) + 1e-4) / 4.0 + 1.0


def moves_to(views: Any) -> Any:
    """MoveAhead actions to each view.

    Args:
        views: (..., N_VIEW) rows, an array or a tensor.

    Returns:
        (...), of the same type.
    """
    return _MOVES_UNIT * views[..., _MOVES] ** 2


def to_agent_frame(xy: NDArray[np.float64], view: View) -> NDArray[np.float64]:
    """Map coordinates as coordinates ahead and to the left of the agent.

    Args:
        xy: (n, 2) metres along the axes of the map, relative to the agent.
        view: the agent's pose, for its heading.

    Returns:
        (n, 2) metres ahead and to the left.
    """
    c, s = view.direction
    return np.stack([c * xy[:, 0] + s * xy[:, 1], c * xy[:, 1] - s * xy[:, 0]], 1)


class ViewSurroundings:
    """Remaining mass and unexplored space around nodes."""

    def __init__(self, known: SemanticMap, xyz: NDArray[np.float64], weight: NDArray[np.float64]) -> None:
        """Sum mass and unexplored space over squares around every cell of the map.

        Args:
            known: the map.
            xyz: (n, 3) sample points, metres.
            weight: (n,) their mass.
        """
        i0, i1, j0, j1 = known.extent(2)
        self._corner = np.array([i0, j0])
        mass = np.zeros((i1 - i0, j1 - j0))
        cells = np.floor(xyz[:, :2] / CELL_M + 0.5).astype(np.int64) + HALF - self._corner
        inside = ((cells >= 0) & (cells < np.array(mass.shape))).all(1)
        np.add.at(mass, tuple(cells[inside].T), weight[inside])
        dark = (known.explored[i0:i1, j0:j1] == 0).astype(np.float64)
        sides = [2 * int(radius / CELL_M) + 1 for radius in RADII_M]
        self._layers = [log_scale(_sums(mass, side)) for side in sides]
        self._layers += [_sums(dark, side) / side**2 for side in sides]

    def at(self, nodes: NDArray[np.int32]) -> NDArray[np.float64]:
        """The sums around some nodes.

        Args:
            nodes: (n, 2) cells.

        Returns:
            (n, 2 R) float64 for the R radii of ``RADII_M``: first the masses (:func:`log_scale`), then the shares of
                unexplored cells.
        """
        cells = tuple((nodes - self._corner).T)
        return np.stack([layer[cells] for layer in self._layers], 1)


def _sums(values: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Sum of the values over a square of ``side`` cells around every cell."""
    return np.asarray(cv2.boxFilter(values, -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT))


def _quarters(turned: NDArray[np.int64], headings: int) -> NDArray[np.int64]:
    """Headings (n,), counted to the left of the agent's, as the nearest quarter turns; each quarter has a column."""
    return (8 * turned + headings) // (2 * headings) % 4


def view_rows(
    valued: ViewValues,
    at: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    choices: tuple[Choice, ...],
    known: SemanticMap,
    around: ViewSurroundings,
) -> F32:
    """The tokens of some views.

    Args:
        valued: all views.
        at: node, heading and pitch numbers of n views, (n,) each.
        choices: their n choices.
        known: the map.
        around: mass and unexplored space around nodes.

    Returns:
        (n, N_VIEW) float32.
    """
    n, h, p = at
    here, nodes, kept = known.view, valued.nodes[n], valued.kept
    score = np.maximum([choice.score for choice in choices], 1e-12)
    looks, space, opens = valued.looks[at], valued.space[at], valued.opens[at]
    steps, moves = valued.steps[n, h], valued.moves[n, h]
    xy = (nodes - np.array([here.i, here.j])) * CELL_M
    rows = np.zeros((len(n), N_VIEW), np.float32)
    rows[:, 0] = np.log10(score / score.max(initial=1e-12))
    rows[:, 1], rows[:, 2], rows[:, 3] = log_scale(looks - space), log_scale(space), log_scale(opens)
    rows[:, 4], rows[:, 5] = log_scale(valued.looks[n, :, p].sum(1)), log_scale(score)
    rows[:, _MOVES], rows[:, 7] = np.sqrt(moves / _MOVES_UNIT), (steps - moves) / 4.0
    rows[:, 8] = [choice.opens for choice in choices]
    rows[:, IS_KEPT] = [kept is not None and choice.view == kept.view for choice in choices]
    rows[:, AHEAD], rows[:, 12] = to_agent_frame(xy, here) / 5.0, np.hypot(xy[:, 0], xy[:, 1]) / 5.0
    rows[:, 13] = np.log10(np.minimum(valued.cost[at], 1e3))
    rows[:, VISITED] = known.visited[nodes[:, 0], nodes[:, 1]] > 0
    headings = valued.looks.shape[1]
    rows[np.arange(len(n)), _PLAIN + _quarters((h - here.heading) % headings, headings)] = 1.0
    rows[np.arange(len(n)), _PLAIN + 4 + p] = 1.0
    rows[:, _PLAIN + 4 + len(PITCHES_DEG) :] = around.at(nodes)
    return rows
