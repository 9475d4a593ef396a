"""Where a thing stands, in words: the anchors and relations that a person would name, found from the map.

A kettle stands on the countertop, next to the microwave: one anchor holds it, one is near. Of the anchors and relations
that the map allows, those are named at which things of this kind are usually kept, by common sense.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.objects.model import RELATIONS, Spot
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.affordances import affordance
from ucon.perception.places.place_kernels import INSIDE, NEXTTO, ONTOP, UNDER
from ucon.readers.anchor_reader import default_reader


@dataclass(frozen=True)
class Slack(Shared):
    """Tolerances for inexact boxes.

    The values for a detector that errs (``INEXACT``) were chosen on 2,403 of its sightings in 5 lives of ``lives_val``:
    they name the true relation and anchor for .69 of them, the values for exact boxes for .60.
    """

    aside_m: float = 0.05
    """How far beyond the sides of a box its top is taken to extend, metres."""
    above_m: float = 0.08
    """How far above or below the top of a box a thing that stands on it may begin, metres."""
    off_m: float = 0.05
    """Distance from the top, metres, over which the fit falls to a third: a cup is on the tray, not the table below."""
    sunk_m: float = 0.0
    """A thing that begins this far below the top of another one, metres, is certainly inside it."""
    falls_m: float = 0.25
    """Distance to an anchor, metres, over which the fit of being next to it falls to a third."""
    looks: int = 0
    """Sides from which an anchor must have been detected to count in full; with fewer it counts in proportion."""


EXACT = Slack()
INEXACT = Slack(aside_m=0.02, above_m=0.15, off_m=0.1, sunk_m=0.2, falls_m=0.12, looks=5)
#: A thing that lies on another one begins where that one ends, to within this, metres.
_LAID_M = 0.015
#: A thing inside another one begins at least this far below its top, metres: butter on the fridge is not in it.
_SUNK_M = 0.01
#: How far away a thing is still next to another one, metres.
_NEAR_M = 0.6
#: Fit of a thing within a box without compartments that is not on its top: on one of its lower surfaces.
_LOWER: Final = 0.4
#: A thing whose lower side is this close to that of another one is under it, or on the same floor, metres.
_FLOOR_M = 0.15
#: Least probability of an anchor and relation by common sense.
_LEAST = 1e-3


def spot_of(known: SemanticMap, target: str, box: NDArray[np.float64]) -> Spot:
    """The relations and anchors of a thing; () if nothing is near.

    Args:
        known: the map.
        target: category of the thing.
        box: (6,) x0 y0 z0 x1 y1 z1 of the thing, metres.
    """
    n, slack = known.n_tracks, INEXACT if known.inexact else EXACT
    boxes, sure = known.box[:n], _sureness(known, slack)
    there = (boxes[:, 3] >= boxes[:, 0]) & (known.kind[:n] == 0) & ~known.stale[:n]
    middle = 0.5 * (box[:3] + box[3:])
    gap = np.maximum(np.maximum(boxes[:, :2] - box[3:5], box[:2] - boxes[:, 3:5]), 0.0)
    gap = np.hypot(gap[:, 0], gap[:, 1])
    best: dict[bool, tuple[float, tuple[str, str]]] = {}
    for track in np.flatnonzero(there & (gap <= _NEAR_M)).tolist():
        name = known.category[track]
        if name in ("", target):
            continue
        sense = _common_sense(target, name)
        for relation, fit in _fits(affordance(name).offers, boxes[track], box, middle, float(gap[track]), slack):
            if relation == ONTOP and _is_covered(boxes[there], boxes[track], box, middle):
                continue
            score, holds = fit * max(float(sense[relation]), _LEAST) * sure[track], relation != NEXTTO
            if score > best.get(holds, (0.0,))[0]:
                best[holds] = score, (RELATIONS[relation], name)
    return tuple(best[holds][1] for holds in (True, False) if holds in best)


def _sureness(known: SemanticMap, slack: Slack) -> NDArray[np.float64]:
    """How certain (T,) it is that tracks exist: the share found of the looks needed to be certain."""
    if known.hypotheses is None or not slack.looks:
        return np.ones(known.n_tracks)
    found, _ = known.hypotheses.support(known.n_tracks)
    return np.minimum(found / slack.looks, 1.0)


def _is_covered(
    boxes: NDArray[np.float64], anchor: NDArray[np.float64], box: NDArray[np.float64], middle: NDArray[np.float64]
) -> bool:
    """Whether something, such as a tray, lies between an anchor's top and a thing above it, right under the thing."""
    over = (middle[:2] >= boxes[:, :2]).all(1) & (middle[:2] <= boxes[:, 3:5]).all(1)
    between = (boxes[:, 2] >= anchor[5] - _LAID_M) & (boxes[:, 5] > anchor[5] + _LAID_M)
    return bool((over & between & (np.abs(box[2] - boxes[:, 5]) <= _LAID_M)).any())


def _fits(
    offers: NDArray[np.bool_], anchor: NDArray[np.float64], box: NDArray[np.float64], middle: NDArray[np.float64],
    gap_m: float, slack: Slack,
) -> list[tuple[int, float]]:  # fmt: skip
    """Relations that a thing may have to an anchor, and how well each fits."""
    found = []
    aside_m = slack.aside_m
    over = bool((middle[:2] >= anchor[:2] - aside_m).all() and (middle[:2] <= anchor[3:5] + aside_m).all())
    within = over and anchor[2] - aside_m <= middle[2] <= anchor[5] + aside_m
    if over and offers[ONTOP]:
        if (off_m := abs(float(box[2] - anchor[5]))) <= slack.above_m:
            found.append((ONTOP, float(np.exp(-off_m / slack.off_m))))
        elif within and not offers[INSIDE] and box[2] > anchor[2] + _FLOOR_M:
            found.append((ONTOP, _LOWER))
    if within and offers[INSIDE] and (below_m := float(anchor[5] - box[2])) > _SUNK_M:
        found.append((INSIDE, min(below_m / slack.sunk_m, 1.0) if slack.sunk_m else 1.0))
    if over and offers[UNDER] and box[2] <= anchor[2] + _FLOOR_M and middle[2] < anchor[5] - 0.1:
        found.append((UNDER, 1.0))
    if not over and anchor[2] - 0.1 <= box[2] <= anchor[5] + 0.1:
        found.append((NEXTTO, float(np.exp(-gap_m / slack.falls_m))))
    return found


@lru_cache(maxsize=65536)
def _common_sense(target: str, anchor: str) -> NDArray[np.float64]:
    """Probability (4,) of an anchor and each relation before any habit is read."""
    belief = default_reader().read(target, ()).belief((anchor,))
    return np.asarray(belief.p[0] * belief.relation[0], np.float64)
