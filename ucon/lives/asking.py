"""Requests of a life as episodes: the home at that time, and the shortest path from wherever the robot stands."""

from __future__ import annotations

import numpy as np

from ucon.core.errors import EpisodeError
from ucon.core.sharing import Shared
from ucon.habits.types import HabitDataset
from ucon.lives.clock import day_and_slot
from ucon.lives.life import Life, Place
from ucon.lives.timeline import Timeline
from ucon.scenes.spec import GRID_M
from ucon.sim.cache import load_house
from ucon.sim.paths import distances
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.episode import Episode, Start
from ucon.task.rules import task_rules
from ucon.task.search import Pose
from ucon.task.solve import Solver


class Asking(Shared):
    """The requests of one life."""

    def __init__(self, life: Life, dataset: HabitDataset, *, told: bool = True, stale: bool = True) -> None:
        """Take a life.

        Args:
            life: the life.
            dataset: the habits with which it was made.
            told: whether changed habits are given from the day of the change on, or never.
            stale: whether the habits that they replace are still given from then on.

        Raises:
            EpisodeError: the life was made with other habits.
        """
        if life.habits_hash != dataset.sha256:
            raise EpisodeError(
                f"life {life.id}: made with habits '{life.habits}' {life.habits_hash[:12]}, the dataset in use is "
                f"'{dataset.name}' {dataset.sha256[:12]}; choose those habits or make the lives again"
            )
        self.life, self.timeline = life, Timeline(life)
        self.dataset, self._told, self._stale = dataset, told, stale
        self.house, self._rules = load_house(life.scene), task_rules(life.task)
        self._eyes = RasterRenderer(fov_deg=self._rules.fov_deg, counting_fov_deg=self._rules.fov_deg)

    def told_entries(self, day: int) -> tuple[tuple[str, int], ...]:
        """Ids of the entries whose habits are given on a day, each with the day on which they were first given."""
        life, since = self.life, self.life.change_day
        changed = since is not None and day >= since
        kept = [one for one in life.possessions if self._stale or not (changed and one.later)]
        found = [(name, 0) for one in kept for name in one.entries]
        if self._told and changed:
            assert since is not None
            found += [(name, since) for one in life.possessions for name in one.later]
        return tuple(found)

    def obeys(self, number: int) -> bool:
        """Whether a sentence that is given at a request supports the place where the requested thing is."""
        asked = self.life.requests[number]
        told = dict(self.told_entries(day_and_slot(asked.time)[0]))
        for name, index in self.timeline.place(asked.possession, asked.time).origins:
            habits = self.dataset.entries[self.dataset.entry_number[name]].habits
            if name in told and any(index in habit.supports for habit in habits):
                return True
        return False

    def standing(self, number: int, at: Start) -> Start:
        """Where the robot stands at a request: where it stopped, or the nearest node connected to its dock.

        Since it stopped, something may have been put there, or on the only way out of a corner.
        """
        free = SceneState(self.house, self.timeline.arrangement(self.life.requests[number].time)).free
        home = distances(free, [(self.life.dock.i, self.life.dock.j)]) >= 0
        if home[at.i, at.j]:
            return at
        moves = distances(np.ones_like(free), [(at.i, at.j)])
        nodes = np.argwhere(home)
        i, j = (int(v) for v in nodes[np.argmin(moves[nodes[:, 0], nodes[:, 1]])])
        return Start(i, j, at.heading)

    def episode(self, number: int, start: Start) -> Episode:
        """A request as an episode, with a shortest solution.

        The shortest path counts as at least one move, since the robot may already stand before the requested thing.

        Args:
            number: number of the request.
            start: where the robot stands, a free node.

        Raises:
            EpisodeError: the request cannot be met from this node.
        """
        life, asked = self.life, self.life.requests[number]
        day, slot = day_and_slot(asked.time)
        arrangement, places = self.timeline.arrangement(asked.time), self.timeline.places(asked.time)
        world, target = SceneState(self.house, arrangement), len(life.fixed) + asked.possession
        self._eyes.load(self.house, arrangement)
        solver = Solver(world, self._eyes, self.house.n_instances + target, self._rules)
        solution = solver.solve(Pose(start.i, start.j, start.heading, self._rules.start_height, 0))
        if solution is None:
            raise EpisodeError(
                f"life {life.id}, request {number}: cannot be fulfilled from node ({start.i}, {start.j})"
            )
        entry = self.dataset.entries[self.dataset.entry_number[life.entry_of(asked.possession, day, asked.user)]]
        names = tuple(name for name, _ in self.told_entries(day))
        return Episode(
            id=f"{life.id}/{number:03d}",
            scene=life.scene,
            home_hash=life.home_hash,
            habits=life.habits,
            habits_hash=life.habits_hash,
            task=life.task,
            seed=life.seed,
            split=life.split,
            arrangement=arrangement,
            target=target,
            placed_by=(*((("", -1),) * len(life.fixed)), *map(_origin, places)),
            entries=names,
            task_entries=tuple(one.entries[0] for one in life.possessions),
            start=start,
            shortest_path_m=max(solution.path_m, GRID_M),
            solution=solution.digits,
            context=life.context(day, slot, entry.household, asked.person),
        )


def _origin(place: Place) -> tuple[str, int]:
    return place.origins[0] if place.origins else ("", -1)
