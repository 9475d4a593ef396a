"""Fixes a few places for every possession, so that any choice of one place for each fits together.

While they are made, all places of all possessions are in the home at once, as obstacles for one another. So no two of
them touch, and the floor stays connected wherever things are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ucon.core.errors import PlacementError
from ucon.habits.hosting import Hosted
from ucon.lives.life import Place
from ucon.lives.making.possessions import Owned
from ucon.lives.meeting import meet, object_boxes
from ucon.objects.model import Relation
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.placement import import_anchor, importable, place
from ucon.sim.placement.floor import nodes_taken
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import object_box
from ucon.task.making.draft import instances_of, rounded

#: Most places of a possession by the household's habits, by the habits that it changes to, and by mistake.
MOST_KEPT, MOST_LATER, MOST_STRAY = 6, 3, 2
#: Fewest places by the household's habits.
LEAST_KEPT = 2
#: Least gap between two places, metres.
_GAP_M = 0.001
#: How many instances of an anchor are tried.
_INSTANCES_TRIED = 3
#: How many relations and anchors are tried for places by mistake.
_STRAYS_TRIED = 6

Wanted = tuple[Relation, str]
"""Relation and anchor category."""
Origins = tuple[tuple[str, int], ...]


@dataclass
class Settled:
    """A possession and its places so far."""

    owned: Owned
    changes: bool = False
    kept: list[Place] = field(default_factory=list)
    later: list[Place] = field(default_factory=list)
    stray: list[Place] = field(default_factory=list)

    @property
    def later_hosts(self) -> tuple[Hosted, ...]:
        """The entry to which its habits change; () if they do not."""
        return (self.owned.other,) if self.changes and self.owned.other else ()

    @property
    def complete(self) -> bool:
        """Whether it has enough places."""
        return len(self.kept) >= LEAST_KEPT and (not self.changes or bool(self.later))


class PlaceMaker:
    """Makes the places of possessions in one home.

    Attributes:
        house: the home.
        categories: categories of all possessions that may get places; none of them is an anchor.
        arrangement: the home without its own things of these categories, with added anchors and all places so far.
        fixed: anchors that were added.
    """

    def __init__(self, house: House, categories: Iterable[str], rng: np.random.Generator) -> None:
        """Remove the home's own things of the possessions' categories.

        Args:
            house: the home.
            categories: see the attribute.
            rng: decides anchors and poses.
        """
        self.house, self.categories, self._rng = house, set(categories), rng
        self.arrangement = Arrangement(removed=instances_of(house, self.categories))
        self.fixed: tuple[PlacedObject, ...] = ()
        self._empty = Surroundings(house, self.arrangement)
        self._instances: dict[str, list[int]] = {}
        for instance, name in enumerate(house.categories):
            if instance not in self.arrangement.removed:
                self._instances.setdefault(name, []).append(instance)

    def add_anchors(self, names: Iterable[str], most: int) -> None:
        """Add anchors that the home lacks, before any place is made.

        Args:
            names: categories, the most wanted first.
            most: most anchors to add.
        """
        for name in names:
            if len(self.fixed) == most:
                return
            if name in self.categories or name in self._instances or not importable(name):
                continue
            try:
                added = self._add(import_anchor(self.house, self.arrangement, name, self._rng))
            except PlacementError:
                continue
            self._instances[name] = [self.house.n_instances + len(self.fixed)]
            self.fixed = (*self.fixed, added)

    def blocked(self, placed: PlacedObject) -> tuple[tuple[int, int], ...]:
        """Nodes that an object blocks in the home without possessions."""
        return tuple((int(i), int(j)) for i, j in nodes_taken(self._empty, object_box(placed)))

    def settle(self, things: Sequence[Settled]) -> None:
        """Make places for things, one for each thing in turn, so that none is left without places."""
        for plan in (self._by_habit, self._by_mistake):
            waiting = [(thing, plan(thing)) for thing in things]
            while waiting := [(thing, queue) for thing, queue in waiting if queue]:
                for thing, queue in waiting:
                    self._settle(thing, *queue.pop(0))

    def drop(self, things: Sequence[Settled]) -> None:
        """Take the places of some things out of the home again."""
        gone = {place.object for thing in things for place in (*thing.kept, *thing.later, *thing.stray)}
        kept = [placed for placed in self.arrangement.objects if placed not in gone]
        self.arrangement = replace(self.arrangement, objects=(), blocked=())
        for placed in kept:
            self._add(placed)

    def _add(self, placed: PlacedObject) -> PlacedObject:
        """Add an object, its pose rounded to 6 decimals, as it will be stored."""
        placed = rounded(placed)
        objects = (*self.arrangement.objects, placed)
        blocked = tuple(sorted({*self.arrangement.blocked, *self.blocked(placed)}))
        self.arrangement = replace(self.arrangement, objects=objects, blocked=blocked)
        return placed

    def _by_habit(self, thing: Settled) -> list[tuple[str, Wanted, Origins]]:
        """Where a thing is kept, and where it will be kept after its habits change."""
        kinds = (("kept", thing.owned.hosts), ("later", thing.later_hosts))
        return [(kind, *item) for kind, hosts in kinds for item in self._ordered(hosts).items()]

    def _by_mistake(self, thing: Settled) -> list[tuple[str, Wanted, Origins]]:
        """Where a thing may be left by mistake: where other households keep it, or where other things are."""
        by_habit = {wanted for _, wanted, _ in self._by_habit(thing)}
        found = [w for w in (*self._ordered(thing.owned.elsewhere), *self._anywhere()) if w not in by_habit]
        return [("stray", wanted, ()) for wanted in found[:_STRAYS_TRIED]]

    def _anywhere(self) -> list[Wanted]:
        """Relations and anchors at which other things are, in random order."""
        names = self.house.categories + tuple(placed.category for placed in self.fixed)
        used = sorted({(o.relation, names[o.anchor]) for o in self.arrangement.objects if o.relation != "imported"})
        return [used[int(k)] for k in self._rng.permutation(len(used))]

    def _ordered(self, hosts: Sequence[Hosted]) -> dict[Wanted, Origins]:
        """Relations and anchors of entries in random order, with all placements that name them."""
        found: dict[Wanted, Origins] = {}
        for host in hosts:
            for index in host.realisable:
                one = host.entry.placements[index]
                if one.anchor not in self.categories:
                    key = (one.relation, one.anchor)
                    found[key] = (*found.get(key, ()), (host.entry.id, index))
        keys = list(found)
        return {keys[int(k)]: found[keys[int(k)]] for k in self._rng.permutation(len(keys))}

    def _settle(self, thing: Settled, kind: str, wanted: Wanted, origins: Origins) -> None:
        """Add one place, if possible and still wanted; all placements that name it become its origins."""
        places: list[Place] = getattr(thing, kind)
        if len(places) == {"kept": MOST_KEPT, "later": MOST_LATER, "stray": MOST_STRAY}[kind]:
            return
        relation, anchor = wanted
        for instance in self._rng.permutation(self._instances.get(anchor, []))[:_INSTANCES_TRIED]:
            category = thing.owned.category
            try:
                placed = place(self.house, self.arrangement, category, relation, int(instance), self._rng)
            except PlacementError:
                continue
            if self._touches(placed):
                continue
            placed = self._add(placed)
            places.append(Place(placed, self.blocked(placed), origins))
            return

    def _touches(self, placed: PlacedObject) -> bool:
        """Whether an object touches another place: it might lean on a thing there, which may later be elsewhere."""
        others = [object_boxes(other) for other in self.arrangement.objects[len(self.fixed) :]]
        return bool(others) and meet(object_boxes(placed), np.concatenate(others), _GAP_M)
