"""Places in the homes of stored episodes, as L3MVN would see them: the categories near each, and where the target is.

Privileged: for fitting and measuring only. A place is the square of 4 m around a piece of furniture. The first place of
a case is around the target's anchor; the others are around random furniture outside that square.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.envs.knowledge import HabitSource
from ucon.language.choice import Option, Question
from ucon.language.labels import label_set
from ucon.language.phrases import phrase
from ucon.retrieval.levels import FIXED_LEVELS
from ucon.sim.cache import load_house
from ucon.sim.state import arrangement_boxes
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

SIDE_M: Final = 4.0
PLACES: Final = 4
LABELS: Final = 20
THINGS: Final = 20


@dataclass(frozen=True, eq=False)
class PlaceCase:
    """One episode as plain names with spaces."""

    id: str
    labels: tuple[str, ...]
    """Labels to choose from, the target first."""
    places: tuple[tuple[str, ...], ...]
    """Categories near each place, by falling floor area; the true place first."""
    habits: dict[str, tuple[str, ...]]
    """Habits by level."""


def case_of(episode: Episode, source: HabitSource) -> PlaceCase | None:
    """The case of an episode; None where the home has too little furniture to compare.

    Args:
        episode: stored episode.
        source: gives the habits.
    """
    house, placed = load_house(episode.scene), episode.arrangement.objects
    names = [*house.categories, *(thing.category for thing in placed)]
    boxes = arrangement_boxes(house, episode.arrangement)
    gone = set(episode.arrangement.removed) | set(range(house.n_items, house.n_instances))
    shut = {house.n_instances + k for k, thing in enumerate(placed) if thing.holder >= 0}
    shown = np.array([k not in gone | shut and name != episode.target_category for k, name in enumerate(names)])
    middle = 0.5 * (boxes[:, :2] + boxes[:, 3:5])
    true = middle[episode.target_object.anchor]
    apart = shown & (np.abs(middle - true).max(1) > 0.5 * SIDE_M)
    apart[house.n_items :] = False
    far = np.flatnonzero(apart)
    if len(far) < PLACES - 1:
        return None
    drawn = stream(0, "keeping", episode.id).choice(far, PLACES - 1, replace=False)
    places = tuple(_near(xy, names, boxes, shown) for xy in (true, *middle[drawn]))
    habits: dict[str, tuple[str, ...]] = {level: source.knowledge(episode, level).texts for level in FIXED_LEVELS}
    return PlaceCase(episode.id, label_set(episode.target_category, LABELS), places, habits)


def _near(
    xy: NDArray[np.float64], names: list[str], boxes: NDArray[np.float64], shown: NDArray[np.bool_]
) -> tuple[str, ...]:
    """Categories within the square around ``xy``.

    By the rule of :func:`ucon.perception.mapping.fine_frontiers.labels_near`, applied to everything that stands there.
    """
    half = 0.5 * SIDE_M
    over = shown & (boxes[:, :2] <= xy + half).all(1) & (boxes[:, 3:5] >= xy - half).all(1)
    area: dict[str, float] = {}
    for k in np.flatnonzero(over).tolist():
        area[names[k]] = max(area.get(names[k], 0.0), float(np.prod(boxes[k, 3:5] - boxes[k, :2])))
    return tuple(phrase(name) for name in sorted(area, key=lambda name: (-area[name], name))[:THINGS])


def place_cases(name: str, limit: int | None = None) -> list[PlaceCase]:
    """Cases of a stored set of episodes, without those that give none.

    Args:
        name: of the set.
        limit: number of episodes; None: all.
    """
    source = HabitSource()
    found = (case_of(episode, source) for episode in load_episodes(name)[:limit])
    return [case for case in found if case is not None]


def asked(case: PlaceCase, level: str) -> list[Question]:
    """L3MVN's question about each place; the right answer for the first place is the first label.

    Args:
        case: the episode.
        level: habit level.
    """
    options = tuple(Option(label, (label,)) for label in case.labels)
    habits = case.habits[level]
    return [Question(case.labels[0], habits, options, "", "", things=things) for things in case.places]
