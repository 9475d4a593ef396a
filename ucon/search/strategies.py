"""Which candidates may be chosen: directions (``views``), ``frontiers``, or frontiers and things (``landmarks``).

A strategy object serves one episode: it keeps what it needs from the frames in addition to the semantic map.
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
from ucon.perception.places.affordances import sight_range_m
from ucon.perception.places.target_places import Places
from ucon.perception.views.candidates import Candidate, candidates, frontiers
from ucon.perception.views.heading_candidates import Goal, directions

Info = Mapping[str, Any]


class Strategy(Protocol):
    """Lists the candidates on the map of one episode."""

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Take in a frame.

        Args:
            known: the map, updated with this frame.
            observation: of the frame.
            info: of the frame.
        """
        ...

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """The candidates of a decision.

        Args:
            known: the map.
            planner: paths from the current pose, up to date.
            draw: random numbers of this decision.

        Returns:
            The candidates; the list may be empty.
        """
        ...

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """What was seen around the current node, for prompts.

        Returns:
            One entry for each heading; empty where frames are not kept.
        """
        ...


class Views:
    """One candidate for each heading in which the path is free (LGX, PixelNav)."""

    def __init__(
        self, goal: Goal = "random", least_m: float = 1.0, most_m: float = 5.0, *, images: bool = False
    ) -> None:
        """Choose the node in each direction.

        Args:
            goal: a random node, the farthest, or the one nearest to the centre of the floor in view.
            least_m: least distance of a node, metres.
            most_m: greatest distance of a node, metres.
            images: keep the colour images, for prompts that show them.
        """
        self._goal, self._reach_m = goal, (least_m, most_m)
        self._sightings = Sightings(floor=goal == "floor", images=images)

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Keep the frame if it is level. See :meth:`Strategy.look`."""
        self._sightings.look(known, observation, info)

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """One candidate for each free direction that was looked at from here. See :meth:`Strategy.candidates`."""
        return directions(known, planner, self.sightings(known), self._goal, self._reach_m, draw)

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """What was seen from the current node, one entry for each heading. See :meth:`Strategy.sightings`."""
        return self._sightings.of(known)


class Frontiers:
    """Frontiers of the 0.25 m map, with the categories seen near each."""

    def __init__(self, least_cells: int = 3) -> None:
        """Set the least size.

        Args:
            least_cells: smaller frontiers are left out; cells of 0.25 m.
        """
        self._least_cells = least_cells

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Do nothing: the map is all that this strategy needs."""

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """The frontiers, the cheapest first. See :meth:`Strategy.candidates`."""
        return [
            replace(found, things=tuple((name, 1) for name in labels_near(known, found.view.xy)))
            for found in frontiers(known, planner, self._least_cells)
        ]

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """Always empty: frames are not kept."""
        return []


class FineFrontiers:
    """The frontiers of L3MVN, with the categories seen near each.

    At most four frontiers of the 5 cm map, by falling utility.
    """

    def __init__(self, body: Body, square_m: float = SQUARE_M) -> None:
        """Start with an empty 5 cm map.

        Args:
            body: the agent's camera.
            square_m: side of the square around a frontier whose things count, metres.
        """
        self._fine = FineMap(body)
        self._square_m = square_m

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Add the frame to the 5 cm map. See :meth:`Strategy.look`."""
        self._fine.update(known.view, frame_depth(observation, info))

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """At most four frontiers, by falling utility. See :meth:`Strategy.candidates`."""
        return [self._candidate(known, frontier) for frontier in fine_frontiers(self._fine, known, planner)]

    def _candidate(self, known: SemanticMap, frontier: FineFrontier) -> Candidate:
        """A frontier as a candidate."""
        things = tuple((name, 1) for name in labels_near(known, frontier.xy, self._square_m))
        return Candidate(
            "frontier", frontier.view, frontier.cost, cells=frontier.cells, things=things, utility=frontier.utility
        )

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """Always empty: frames are not kept."""
        return []


class Landmarks:
    """Frontiers, furniture not looked at yet, and closed containers."""

    #: Probability that a frame that shows a place from within sight range misses a target there.
    MISS = 0.1

    def __init__(self, target: str, least_unseen: float = 0.3) -> None:
        """Start an episode.

        Args:
            target: category of the target; its size decides from how far away it can be seen.
            least_unseen: furniture is a candidate while more than this share of its places was not shown.
        """
        book = catalogue()
        self._places = Places(book[target].size[2] if target in book else 0.1)
        self._reach_m = sight_range_m(target)
        self._least_unseen = least_unseen

    def look(self, known: SemanticMap, observation: Mapping[str, Any], info: Info) -> None:
        """Note which places the frame shows. See :meth:`Strategy.look`."""
        places = self._places
        places.refresh(known)
        active = places.searched(~known.opened[: known.n_tracks])
        places.look(known, frame_depth(observation, info), active, self._reach_m, self.MISS)

    def candidates(self, known: SemanticMap, planner: Planner, draw: np.random.Generator) -> list[Candidate]:
        """By kind, the cheapest first within each kind. See :meth:`Strategy.candidates`."""
        return candidates(known, planner, self._places, least_unseen=self._least_unseen)

    def sightings(self, known: SemanticMap) -> list[Sighting]:
        """Always empty: frames are not kept."""
        return []


def _views(info: Info) -> Views:
    return Views()


def _frontiers(info: Info) -> Frontiers:
    return Frontiers()


def _fine_frontiers(info: Info) -> FineFrontiers:
    return FineFrontiers(Body.of(info))


def _landmarks(info: Info) -> Landmarks:
    return Landmarks(str(info["target"]))


#: By name in configurations: a function from the info at an episode's reset to the episode's strategy.
STRATEGIES: dict[str, Callable[[Info], Strategy]] = {
    "views": _views,
    "frontiers": _frontiers,
    "fine_frontiers": _fine_frontiers,
    "landmarks": _landmarks,
}
