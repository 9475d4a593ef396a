"""False sentences among a household's habits: adversarial ones, stale ones, and orders.

The first two kinds are sentences that people wrote for the book. Adversarial sentences are another household's habits
about the same thing that name other places in this home. Stale ones are the household's own habits that name a place
where the thing is not now. Orders tell their reader what to do ("Ignore all other habits. ..."), see
:mod:`ucon.envs.told.orders`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief, unknown_name
from ucon.core.rng import stream
from ucon.core.sharing import Shared
from ucon.envs.told.orders import orders_for
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.sim.cache import load_house
from ucon.task.episode import Episode

#: Kind of sentences that belong to no household; they are in a dataset of :func:`ucon.envs.told.orders.with_orders`.
ORDERS: Final = "orders"
KINDS: Final = ("adversarial", "stale", ORDERS)
#: In place of the row of a sentence that is dropped without replacement.
_NONE: Final = -1


@dataclass(frozen=True)
class Falsehoods(Shared):
    """Replaces some true sentences by false ones, or adds orders.

    ``adversarial``: of the sentences about the target that name a place where the household keeps it, the share is
    replaced by lies. ``stale``: of the sentences that name the place where the target is now, the share is replaced by
    the household's sentences that name another place; all further sentences of this kind are left out, since they are
    the majority (six in seven in the book). If there are too few false sentences, true ones are dropped without
    replacement. ``orders``: nothing is replaced; the number of orders added is the share of the number of sentences
    about the target that name a place, at most eight, without orders that name things the home lacks. The draw depends
    on the kind and the episode's id, not on the share, so a larger share includes the sentences of a smaller one.

    Raises:
        ConfigError: an unknown kind, or a share outside [0, 1].
    """

    kind: str
    share: float

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ConfigError(unknown_name("kind of falsehoods", self.kind, KINDS))
        if not 0.0 <= self.share <= 1.0:
            raise ConfigError(f"env.source.false_share={brief(self.share)}: expected a share from 0 to 1")

    def among(self, base: KnowledgeBase, episode: Episode) -> KnowledgeBase:
        """The knowledge base with falsehoods; all other sentences keep their order.

        Args:
            base: all habits of the household; for orders, from a dataset that has orders.
            episode: says where the target is.

        Raises:
            ConfigError: the dataset does not say which sentence names which place.
        """
        dataset = base.dataset
        if not dataset.labelled:
            raise ConfigError(
                f"env.source.falsehoods={self.kind}: habits '{dataset.name}' have no labels; use habits=book"
            )
        naming = [int(row) for row in base.rows_about(episode.target_category) if dataset.supports(row)]
        if self.kind == ORDERS:
            return self._with_orders(base, episode, len(naming))
        if self.kind == "adversarial":
            true, false, left_out = naming, _lies(dataset, episode), set[int]()
        else:
            now = place_now(dataset, episode)
            true = [row for row in naming if _names(dataset.supports(row), now)]
            false = [row for row in naming if row not in true]
            left_out = set(false)
        draw = stream(0, "falsehoods", self.kind, episode.id)
        true, false = draw.permutation(true).tolist(), draw.permutation(false).tolist()
        count = int(self.share * len(true) + draw.random())
        instead = {row: false[k] if k < len(false) else _NONE for k, row in enumerate(true[:count])}
        told = [instead.get(row, row) for row in base.rows.tolist() if row not in left_out]
        return KnowledgeBase(dataset, _rows(row for row in told if row != _NONE))

    def _with_orders(self, base: KnowledgeBase, episode: Episode, naming: int) -> KnowledgeBase:
        """The knowledge base with orders at random positions; ``naming``: number of sentences that name a place."""
        possible = orders_for(base.dataset, episode.target_category, things_of(episode))
        draw = stream(0, "falsehoods", self.kind, episode.id)
        added = draw.permutation(possible)
        before = draw.integers(len(base) + 1, size=len(added))
        count = int(self.share * naming + draw.random())
        return KnowledgeBase(base.dataset, np.insert(base.rows, before[:count], added[:count]).astype(np.int32))


def place_now(dataset: HabitDataset, episode: Episode) -> Placement:
    """The placement that the target of an episode follows. Privileged."""
    entry, number = episode.placed_by[episode.target]
    return dataset.entries[dataset.entry_number[entry]].placements[number]


def things_of(episode: Episode) -> frozenset[str]:
    """Categories of all things in an episode's home. Privileged."""
    gone, house = set(episode.arrangement.removed), load_house(episode.scene)
    standing = {name for k, name in enumerate(house.categories) if k not in gone}
    return frozenset(standing | {thing.category for thing in episode.arrangement.objects})


def elsewhere(dataset: HabitDataset, episode: Episode, category: str) -> list[int]:
    """Rows of other households' sentences that place a category at things of this home, but not where it is kept.

    Args:
        dataset: habits of all households.
        episode: says which household lives in the home, and what is in it.
        category: the thing that the sentences are about.
    """
    kept = {_place(p) for entry in _own(dataset, episode, category) for p in entry.placements}
    there, found = things_of(episode), []
    for entry in dataset.entries_of(category):
        if entry.id in episode.entries:
            continue
        for row, habit in enumerate(entry.habits, int(dataset.first_row[dataset.entry_number[entry.id]])):
            if _all_elsewhere(entry, habit, there, kept):
                found.append(row)
    return found


def _lies(dataset: HabitDataset, episode: Episode) -> list[int]:
    """Rows of sentences that place the target in this home, at things other than the one where it is."""
    anchor = place_now(dataset, episode).anchor
    rows = elsewhere(dataset, episode, episode.target_category)
    return [row for row in rows if all(place.anchor != anchor for place in dataset.supports(row))]


def _all_elsewhere(entry: Entry, habit: Habit, there: Collection[str], kept: Collection[tuple[str, str]]) -> bool:
    places = [entry.placements[k] for k in habit.supports]
    return bool(places) and all(place.anchor in there and _place(place) not in kept for place in places)


def _own(dataset: HabitDataset, episode: Episode, category: str) -> list[Entry]:
    return [entry for entry in dataset.entries_of(category) if entry.id in episode.entries]


def _names(places: Collection[Placement], place: Placement) -> bool:
    return any(_place(one) == _place(place) for one in places)


def _place(place: Placement) -> tuple[str, str]:
    return place.relation, place.anchor


def _rows(rows: object) -> NDArray[np.int32]:
    return np.fromiter(rows, np.int32)  # type: ignore[call-overload, no-any-return]
