"""What a search does next, as text for people: ``look at: bottom cabinet 24 (inside)``.

Things are numbered by their tracks on the agent's own map. Distances in metres are straight lines.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from ucon.objects.model import RELATIONS, Relation
from ucon.perception.detectors.base import vocabulary
from ucon.perception.drawing.overlay import words
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View
from ucon.perception.places.containers import open_reach_m
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.views import view_kernels as kernels
from ucon.perception.views.candidates import Candidate
from ucon.perception.views.viewpoints import Choice, ViewValues
from ucon.search.search_decision import SearchDecision
from ucon.search.searcher import Searcher

_AT: Final[dict[Relation, str]] = {"ontop": "on top", "inside": "inside", "under": "under", "nextto": "beside"}
_MOST_THINGS: Final = 3


class Aim(NamedTuple):
    """What a choice is for.

    Attributes:
        kind: ``frontier``, ``landmark``, ``container``, ``wander``, or ``target`` where the target is in view.
        words: the aim as text.
        why: gain, cost and score as text; "" where they are not known.
    """

    kind: str
    words: str
    why: str


def aim_of(searcher: Searcher, decision: SearchDecision, choice: Choice | None) -> Aim:
    """The aim of a choice. Call it before the choice is made: making it changes the searcher.

    Args:
        searcher: the search, at the decision.
        decision: the decision that is due.
        choice: one of its choices; None turns on the spot.
    """
    if choice is None:
        return Aim("wander", "turn: there is nowhere to go", "")
    away = _away(searcher.map, choice.view)
    actions = _actions(searcher.planner.cost(choice.view))
    if decision.valued is None or choice.gain <= 0.0:
        return Aim("wander", f"go on: {away}", f"nothing promises anything, {actions} away")
    worth = f"worth {choice.gain:.3g}, {actions} away, score {choice.score:.3g}"
    space, opens = _parts(decision.valued, choice)
    looks = choice.gain - space - opens
    if opens > max(space, looks) and (track := _opened(searcher, decision, choice)) >= 0:
        belief = _belief(searcher, decision.expected.mass[track, INSIDE])
        return Aim("container", f"open: {thing(searcher.map, track)}", belief + worth)
    if looks > space and (found := _looked_at(searcher, decision, choice)) is not None:
        track, relation, left = found
        place = f"{thing(searcher.map, track)} ({_AT[RELATIONS[relation]]})"
        return Aim("landmark", f"look at: {place}", _belief(searcher, left) + worth)
    return Aim("frontier", f"explore: frontier {away}", worth)


def aim_to_open(searcher: Searcher) -> Aim:
    """The aim of an Open on the way: the container within reach with most expected mass inside.

    Args:
        searcher: the search; at least one closed container is within reach.
    """
    assert searcher.expected is not None
    inside = searcher.expected.mass[:, INSIDE]
    track = max(searcher.containers.in_reach(searcher.map), key=lambda t: float(inside[t]))
    why = f"{_belief(searcher, inside[track])}in reach on the way"
    return Aim("container", f"open: {thing(searcher.map, track)}", why)


def aim_at_target(searcher: Searcher) -> Aim:
    """The aim of walking up to the target or, where the detector errs, to a thing that may be the target."""
    if searcher.doubt is None:
        return Aim("target", f"take: {words(searcher.target)}", "it is seen")
    return Aim("target", f"is it the {words(searcher.target)}? {suspect_words(searcher)}", how_sure(searcher))


def suspect_words(searcher: Searcher) -> str:
    """The suspect that the agent is walking up to, as text: its most probable name and its number."""
    assert searcher.doubt is not None
    track = searcher.doubt.suspect
    return f"{words(searcher.map.category[track] or 'something')} {track}"


def how_sure(searcher: Searcher) -> str:
    """As text: the probability that the suspect is the target, and how many of the looks at it called it that."""
    assert searcher.doubt is not None
    looks = searcher.doubt.looks(searcher)[searcher.doubt.suspect]
    named = searcher.doubt.p.get(searcher.doubt.suspect, 0.0)
    found = [name for name, _, _ in looks if name >= 0]
    called = sum(vocabulary()[name] == searcher.target for name in found)
    return f"{named:.0%} sure, called so in {called} of {len(looks)} looks"


def candidate_words(known: SemanticMap, candidate: Candidate) -> str:
    """What going to a candidate is for, as text.

    Args:
        known: the agent's map.
        candidate: one of its candidates.
    """
    away = _away(known, candidate.view)
    if candidate.kind == "container":
        return f"open: {thing(known, candidate.track)}"
    if candidate.kind == "landmark":
        return f"look at: {thing(known, candidate.track)}"
    if candidate.kind == "frontier":
        return f"explore: frontier {away}"
    shown = ", ".join(words(name) for name, _ in candidate.things[:_MOST_THINGS])
    return f"go on: {away}{f', towards {shown}' if shown else ''}"


def thing(known: SemanticMap, track: int) -> str:
    """A thing on the agent's map as text: its category and track number."""
    return f"{words(known.category[track])} {track}"


def _away(known: SemanticMap, view: View) -> str:
    """Straight distance to a pose, as text."""
    if (view.i, view.j) == (known.view.i, known.view.j):
        return "a turn away"
    return f"{math.dist(known.view.xy, view.xy):.1f} m away"


def _actions(n: int) -> str:
    """A number of actions, as text."""
    return "1 action" if n == 1 else f"{n} actions"


def _belief(searcher: Searcher, probability: float) -> str:
    """A probability as text; "" for coverage, whose mass is no probability."""
    return "" if searcher.expecting.locations is None else f"belief {probability:.1%}, "


def _parts(valued: ViewValues, choice: Choice) -> tuple[float, float]:
    """The parts of a choice's gain that are in unexplored space, and behind doors that it opens."""
    view = choice.view
    n = int(np.flatnonzero((valued.nodes[:, 0] == view.i) & (valued.nodes[:, 1] == view.j))[0])
    at = n, view.heading, kernels.PITCHES_DEG.index(view.pitch_deg)
    return float(valued.space[at]), float(valued.opens[at]) if choice.opens else 0.0


def _opened(searcher: Searcher, decision: SearchDecision, choice: Choice) -> int:
    """Track of the container within reach of a view with most expected mass inside; -1 where there is none."""
    known, (x, y) = searcher.map, choice.view.xy
    closed = decision.closed
    box = known.box[closed]
    gap = np.hypot(
        np.maximum(np.maximum(box[:, 0] - x, x - box[:, 3]), 0.0),
        np.maximum(np.maximum(box[:, 1] - y, y - box[:, 4]), 0.0),
    )
    inside = np.where(gap <= open_reach_m(known), decision.expected.mass[closed, INSIDE], 0.0)
    best = int(inside.argmax())
    return int(closed[best]) if inside[best] > 0.0 else -1


def _looked_at(searcher: Searcher, decision: SearchDecision, choice: Choice) -> tuple[int, int, float] | None:
    """Track and relation of which a view shows most expected mass, and that mass; None where it shows none."""
    known, places, reach_m, view = searcher.map, searcher.places, searcher.viewpoints.reach_m, choice.view
    x, y = view.xy
    dx, dy = places.xyz[:, 0] - x, places.xyz[:, 1] - y
    near = np.flatnonzero(dx * dx + dy * dy <= reach_m * reach_m)
    shut = np.zeros(len(decision.expected.mass), bool)
    shut[decision.closed] = True
    track, relation = places.track[near], places.relation[near]
    weight = decision.expected.mass[track, relation] * places.share[near] * places.unseen[near]
    weight[shut[track] & (relation == INSIDE)] = 0.0
    hidden = np.ones(len(near))
    looks = view.heading, known.body.headings, kernels.PITCHES_DEG.index(view.pitch_deg)
    kernels.fade_places(
        x, y, known.body.camera_m, looks, places.xyz[near], places.hollow[near], places.faces[near], weight, reach_m,
        known.height, known.walls, HALF, hidden, 0.0,
    )  # fmt: skip
    shown = np.bincount(4 * track + relation, weight * (1.0 - hidden), minlength=1)
    best = int(shown.argmax())
    return (best // 4, best % 4, float(shown[best])) if shown[best] > 0.0 else None
