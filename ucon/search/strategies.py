"""What may be chosen next: directions (``views``), edges of the known (``frontiers``), or things too (``landmarks``).

A strategy object serves one episode: it keeps what it needs of the frames beside the semantic map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.fine_frontiers import SQUARE_M, FineFrontier, fine_frontiers, labels_near
from ucon.perception.mapping.fine_map import FineMap
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap, frame_depth
from ucon.perception.mapping.sightings import Sighting, Sightings
from ucon.perception.places.target_places import Places, sight_range_m
from ucon.perception.views.candidates import Candidate, candidates, frontiers
from ucon.perception.views.heading_candidates import Goal, directions

Info = Mapping[str, Any]


class Strategy(Protocol):
    """Offers candidates on the map of one episode."""

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Take in the frame that ``known`` was last updated with."""
        ...

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """What may be chosen; the planner is up to date. ``draw`` is this decision's own."""
        ...

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """What was seen around the node where the agent stands, for prompts; empty where none is kept."""
        ...


class Views:
    """One candidate a direction, blocked ones left out (LGX, PixelNav)."""

    def __init__(
        self, goal: Goal = "random", least_m: float = 1.0, most_m: float = 5.0, *, images: bool = False
    ) -> None:
        """``goal``: which node in a direction; nodes from ``least_m`` to ``most_m``; ``images``: keep the frames."""
        self._goal, self._reach_m = goal, (least_m, most_m)
        self._sightings = Sightings(floor=goal == "floor", images=images)

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """See :class:`Strategy`."""
        self._sightings.look(known, observation, info)

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """See :class:`Strategy`."""
        return directions(known, planner, self.sightings(known), self._goal, self._reach_m, draw)

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """See :class:`Strategy`."""
        return self._sightings.of(known)


class Frontiers:
    """Edges of explored space on the 0.25 m map, and what stands near each."""

    def __init__(self, least_cells: int = 3) -> None:
        """``least_cells``: smaller ones are left out."""
        self._least_cells = least_cells

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """The map is all it needs."""

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """See :class:`Strategy`."""
        return [
            replace(found, things=tuple((name, 1) for name in labels_near(known, found.view.xy)))
            for found in frontiers(known, planner, self._least_cells)
        ]

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """None are kept."""
        return []


class FineFrontiers:
    """At most four edges of explored space on the 5 cm map, the most useful first, with what stands near (L3MVN)."""

    def __init__(self, body: Body, square_m: float = SQUARE_M) -> None:
        """``square_m``: side of the square around a frontier whose things count."""
        self._fine = FineMap(body)
        self._square_m = square_m

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """See :class:`Strategy`."""
        self._fine.update(known.view, frame_depth(observation, info))

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """See :class:`Strategy`."""
        return [self._candidate(known, frontier) for frontier in fine_frontiers(self._fine, known, planner)]

    def _candidate(self, known: SemanticMap, frontier: FineFrontier) -> Candidate:
        things = tuple((name, 1) for name in labels_near(known, frontier.xy, self._square_m))
        return Candidate(
            "frontier", frontier.view, frontier.cost, cells=frontier.cells, things=things, utility=frontier.utility
        )

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """None are kept."""
        return []


class Landmarks:
    """Frontiers, furniture not looked at yet, and closed containers: what a policy over things chooses among."""

    #: A frame that shows a place from within sight range still misses the target with this probability.
    MISS = 0.1

    def __init__(self, target: str, least_unseen: float = 0.3) -> None:
        """``target``: its size decides from how far it can be seen; ``least_unseen``: see ``candidates``."""
        book = catalogue()
        self._places = Places(book[target].size[2] if target in book else 0.1)
        self._reach_m = sight_range_m(target)
        self._least_unseen = least_unseen

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """See :class:`Strategy`."""
        places = self._places
        places.refresh(known)
        active = places.searched(~known.opened[: known.n_tracks])
        places.look(known, frame_depth(observation, info), active, self._reach_m, self.MISS)

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """See :class:`Strategy`."""
        return candidates(known, planner, self._places, least_unseen=self._least_unseen)

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """None are kept."""
        return []


def _views(info: Info) -> Views:
    return Views()


def _frontiers(info: Info) -> Frontiers:
    return Frontiers()


def _fine_frontiers(info: Info) -> FineFrontiers:
    return FineFrontiers(Body.of(info))


def _landmarks(info: Info) -> Landmarks:
    return Landmarks(str(info["target"]))


#: By the name that configurations use: makes the strategy of an episode from the info at its reset.
STRATEGIES: dict[str, Callable[[Info], Strategy]] = {
    "views": _views,
    "frontiers": _frontiers,
    "fine_frontiers": _fine_frontiers,
    "landmarks": _landmarks,
}
