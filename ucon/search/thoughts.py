"""The state of a search at one moment, as plain values for pages: belief over things, goal, and other views."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from ucon.search.aims import aim_of
from ucon.search.search_decision import SearchDecision
from ucon.search.searcher import Searcher

#: Most things, and most other views, that are listed.
_MOST_THINGS, _MOST_VIEWS = 16, 5
#: Things with less of the remaining belief are left out.
_LEAST_SHARE: Final = 0.005
#: Number of best views that are searched for other aims.
_LOOKED_THROUGH: Final = 400


class BelievedThing(NamedTuple):
    """A thing on the agent's map with its share of the remaining belief.

    Attributes:
        category: as the agent knows it.
        box: x0, y0, x1, y1 in metres in the start frame.
        share: of the remaining mass of all things, 0 to 1.
    """

    category: str
    box: tuple[float, float, float, float]
    share: float


class OtherView(NamedTuple):
    """A view that could have been chosen: its aim in words, and gain, cost and score in words."""

    words: str
    why: str


class Thoughts(NamedTuple):
    """State of a search after a step.

    Attributes:
        things: the most probable ones, by falling share.
        goal: x, y of the view that the agent is going to, metres in the start frame; None where there is none.
        others: the best views with other aims than the chosen one, where a choice was made in this step.
        relevance: of each given habit, 0 to 1, how much it says about the target's place; () where no habit was read.
    """

    things: tuple[BelievedThing, ...]
    goal: tuple[float, float] | None
    others: tuple[OtherView, ...]
    relevance: tuple[float, ...]


def thoughts_of(searcher: Searcher, decided: SearchDecision | None) -> Thoughts:
    """The state of a search now.

    Args:
        searcher: the search, after its action was chosen.
        decided: the decision made in this step; None where none was due.
    """
    locations = searcher.expecting.locations
    relevance = () if locations is None or locations.relevance is None else tuple(map(float, locations.relevance))
    goal = None if searcher.choice is None else searcher.choice.view.xy
    return Thoughts(_things(searcher), goal, _others(searcher, decided), relevance)


def _things(searcher: Searcher) -> tuple[BelievedThing, ...]:
    expected, known = searcher.expected, searcher.map
    if expected is None or len(expected.mass) != known.n_tracks or searcher.taking:
        return ()
    mass = searcher.places.remaining_mass(expected.mass).sum(1)
    total = float(mass.sum())
    shown = [t for t in np.argsort(-mass, kind="stable")[:_MOST_THINGS].tolist() if mass[t] > _LEAST_SHARE * total]
    return tuple(
        BelievedThing(known.category[t], tuple(float(known.box[t, k]) for k in (0, 1, 3, 4)), float(mass[t]) / total)  # type: ignore[arg-type]
        for t in shown
        if known.seen(t)
    )


def _others(searcher: Searcher, decided: SearchDecision | None) -> tuple[OtherView, ...]:
    """The best views with other aims than the chosen one, one for each aim."""
    if decided is None or decided.valued is None or searcher.choice is None:
        return ()
    valued, found = decided.valued, {aim_of(searcher, decided, searcher.choice).words: ""}
    flat = valued.score.ravel()
    n = min(_LOOKED_THROUGH, len(flat))
    best = np.argpartition(-flat, n - 1)[:n]
    for row in best[np.argsort(-flat[best], kind="stable")]:
        if len(found) > _MOST_VIEWS or not flat[row] > 0.0:
            break
        node, heading, pitch = np.unravel_index(int(row), valued.score.shape)
        choice = valued.at(int(node), int(heading), int(pitch))
        if choice.gain > 0.0:
            aim = aim_of(searcher, decided, choice)
            found.setdefault(aim.words, aim.why)
    return tuple(OtherView(words, why) for words, why in found.items() if why)
