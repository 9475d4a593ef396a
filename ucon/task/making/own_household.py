"""A user's own household in a home: an object, habit sentences about it, and where it is kept."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, EpisodeError, UconError
from ucon.habits.book import book, book_anchors
from ucon.habits.rules import OWN_LIMITS, count_fault, habit_fault, line_fault, placement_fault
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.habits.verdicts import Triple, Verdicts
from ucon.language.near_names import unknown_category
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS, Relation
from ucon.scenes.library import check_home_name
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.making.living import living_in
from ucon.task.making.sampler import EpisodeSampler
from ucon.task.rules import PAPER, TaskRules
from ucon.task.spoken import spoken_place

#: Name of the user's household, and of its dataset.
HOUSEHOLD: Final = "you"
NAME: Final = "own"
#: Most places that are tried, those most probable given the habits first.
_TRIED: Final = 12
#: Maps a target and its habits to the names of A anchors and the joint probability (A, 4) of anchor and relation.
ReadPlaces = Callable[[str, Sequence[str]], tuple[Sequence[str], NDArray[np.float64]]]


class FaultsError(UconError):
    """All faults of a request, one per line; ``faults`` has them as a tuple."""

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = tuple(faults)


@dataclass(frozen=True)
class OwnPlacement:
    """A request to keep an object in a home.

    Attributes:
        scene: name of the home.
        target: category of the object.
        habits: sentences about the object.
        place: where the object is kept; None: where the habits say.
    """

    scene: str
    target: str
    habits: tuple[str, ...]
    place: Placement | None = None

    @classmethod
    def of(cls, scene: str, target: str, habits: Sequence[str], place: str | None) -> OwnPlacement:
        """Make a request from the arguments of a command line, and check them.

        Args:
            scene: name of a home.
            target: category of the object.
            habits: sentences about the object.
            place: ``relation:anchor``, or None.

        Raises:
            FaultsError: lists all faults.
        """
        faults = list(_scene_faults(scene))
        if target not in catalogue():
            faults.append(f"--object: {unknown_category('object', target)}")
        if fault := count_fault(1, len(habits), OWN_LIMITS):
            faults.append(f"--habit: {fault}")
        for number, text in enumerate(habits, 1):
            if fault := line_fault(text) or habit_fault(text, (), 1, OWN_LIMITS):
                faults.append(f"--habit, number {number}: {fault}")
        found = None if place is None else _placement(place)
        if isinstance(found, Placement):
            fault = placement_fault(target, [], found, book_anchors())
            found = found if fault is None else fault
        if isinstance(found, str):
            faults.append(f"--place {place}: {found}")
        if faults:
            raise FaultsError(faults)
        return cls(scene, target, tuple(habits), cast("Placement | None", found))


def _scene_faults(scene: str) -> Iterable[str]:
    """The fault in a scene's name, if any."""
    try:
        check_home_name(scene)
    except UconError as error:
        yield f"--scene: {error}"


def _placement(text: str) -> Placement | str:
    """The placement that ``relation:anchor`` names, or what is wrong with the text."""
    relation, colon, anchor = text.partition(":")
    if not colon:
        return f"expected RELATION:ANCHOR, as in nextto:laptop; relations are {', '.join(RELATIONS)}"
    return Placement(cast(Relation, relation), anchor)


def others_of(scene: str, targets: Collection[str]) -> list[Entry]:
    """The habit book's entries of a home's household for all other categories, in the order of the book.

    Args:
        scene: name of the home.
        targets: categories that the user's own entries are about.
    """
    living = living_in(load_house(scene), book())
    found = {host.entry for name, hosts in living.items() if name not in targets for host in hosts}
    return sorted(found, key=lambda entry: book().entry_number[entry.id])


def own_household(wishes: Mapping[OwnPlacement, Placement], others: Sequence[Entry]) -> HabitDataset:
    """A dataset of the requests as entries, with the household's other entries.

    Args:
        wishes: the requests, and where each object is kept.
        others: entries from :func:`others_of`.
    """
    own = tuple(
        Entry(own_entry(wish.target), wish.target, HOUSEHOLD, (place,), _telling(wish.habits))
        for wish, place in wishes.items()
    )
    entries = (*own, *others)
    triples: set[Triple] = {(e.category, p.relation, p.anchor) for e in entries for p in e.placements}
    known = {triple: verdict for triple, verdict in book().verdicts.of.items() if triple in triples}
    for wish, place in wishes.items():
        known.pop((wish.target, place.relation, place.anchor), None)  # tried here instead
    return HabitDataset(NAME, entries, verdicts=Verdicts(known))


def _telling(habits: Iterable[str]) -> tuple[Habit, ...]:
    return tuple(Habit(text, (0,)) for text in habits)


def own_entry(target: str) -> str:
    """Id of the user's own entry about a category."""
    return f"{target}/own"


def likely_places(wish: OwnPlacement, read: ReadPlaces) -> list[tuple[Placement, float]]:
    """Places for the object in the home, the most probable first.

    Args:
        wish: the request; if it names a place, this is the only one.
        read: reads the habits.

    Returns:
        At most 12 placements and their probabilities.
    """
    if wish.place is not None:
        return [(wish.place, 1.0)]
    house = load_house(wish.scene)
    names, p = read(wish.target, wish.habits)
    found = [
        (Placement(relation, name), float(p[row, column]))
        for row, name in enumerate(names)
        for column, relation in enumerate(RELATIONS)
        if name in house.categories
    ]
    allowed = [one for one in found if placement_fault(wish.target, [], one[0], book_anchors()) is None]
    return sorted(allowed, key=lambda one: -one[1])[:_TRIED]


def own_episode(
    wish: OwnPlacement, read: ReadPlaces, seed: int = 0, rules: TaskRules = PAPER
) -> tuple[Episode, HabitDataset, Placement, float]:
    """Make an episode from a request; places are tried in order of decreasing probability.

    Args:
        wish: the request.
        read: reads the habits.
        seed: of the episode.
        rules: rule set under which the episode must be solvable.

    Returns:
        The episode, the dataset it belongs to, the place, and the place's probability given the habits.

    Raises:
        ConfigError: the object can be put in none of the places, or cannot be found there.
    """
    reasons, others = [], others_of(wish.scene, [wish.target])
    for place, chance in likely_places(wish, read):
        dataset = own_household({wish: place}, others)
        try:
            episode = EpisodeSampler(dataset, rules=rules).sample(wish.scene, seed, targets=[wish.target])
        except EpisodeError as error:
            reasons.append(str(error))
            continue
        if episode.placed_by[episode.target][0] == own_entry(wish.target):
            return replace(episode, id=f"{wish.scene}/{wish.target}/own"), dataset, place, chance
    where = spoken_place(wish.place.relation, wish.place.anchor) if wish.place else f"any of {len(reasons)} places"
    raise ConfigError(
        f"{wish.scene}: a {wish.target} cannot be kept {where} there, or cannot be found there"
        f"{f' ({reasons[-1]})' if reasons else ''}; give another --place, --object or --scene"
    )
