"""What a search that knows the home would choose, though it knows no more of the target than belief does.

A label for training, never shown to an agent. The expert keeps a map of its own: a walk through the home fills it
before the episode, and then it sees what the agent sees, so both have looked at the same places in vain. It spreads
the agent's own belief over all things of the home and goes where gain over cost is best, cost by the true floor:
greedy in p / (d + c) on a known map. Views that are offered to the agent are compared by how much nearer they bring to
the view that the expert would go to.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.sharing import PartlyShared
from ucon.envs.frame import StartFrame
from ucon.envs.ucon_env import UcONEnv
from ucon.envs.waypoint.searcher import Searcher
from ucon.perception.belief import KNOWN_HOME, Locations
from ucon.perception.planner import UNREACHED
from ucon.perception.reading import Locate, expecting
from ucon.perception.semantic_map import HALF, View
from ucon.perception.viewpoints import Choice
from ucon.sim.paths import distances
from ucon.task.actions import Action
from ucon.task.episode import Episode

#: What the expert makes of a view that leads straight away from its goal, or to which there is no way.
NOTHING: Final = -1.0
#: It has arrived within this cost, which is about what an agent goes until it is asked again.
NEAR: Final = 6.0


class ViewExpert(PartlyShared):
    """Goes along in an environment of its own: on its walk a detector numbers things that the agent never saw.

    Args:
        env: with a detector, and privileged.
        locate: reads the habits, as the agent does.
        miss: chance that a look at a place misses the target there.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_locate", "_free"})

    def __init__(self, env: UcONEnv, locate: Locate, miss: float) -> None:
        self._env, self._locate, self._miss = env, locate, miss

    def begin(self, episode: Episode, level: str, locations: Locations) -> None:
        """Walk through the home of an episode, whose habits at a level say ``locations``, and stand where it starts.

        Raises:
            ConfigError: the environment is not privileged.
        """
        observation, info = self._env.reset(options={"episode": episode, "habit_level": level})
        privileged = info.pop("privileged", None)
        if privileged is None:
            raise ConfigError("the expert needs the home: make its environment with privileged=True")
        believing = expecting(info, self._locate, weights=KNOWN_HOME, locations=locations)
        self._search = Searcher(info, believing, miss=self._miss)
        self._search.map.tour(privileged["tour"]())
        self._search.take_in(observation, info)
        self._frame, self._free = StartFrame(episode.start), self._env.search.world.free

    def follow(self, action: Action) -> None:
        """Do what the agent did."""
        observation, *_, info = self._env.step(int(action))
        self._search.take_in(observation, info)

    def close(self) -> None:
        """Close its environment."""
        self._env.close()

    def __call__(self, choices: Sequence[Choice]) -> NDArray[np.float32]:
        """(n,) by how much going to each offered view brings the expert nearer to its goal, for what that costs.

        1 is straight there, ``NOTHING`` straight away, or no way. ``NOTHING`` for all where it has no goal, or has
        arrived but for how to look: of that the agent knows as much, and its views may be others.
        """
        out = np.full(len(choices), NOTHING, np.float32)
        self._search.expect()
        valued = self._search.decision().valued
        if valued is None or not choices:
            return out
        views = np.array([_numbers(view) for view in (self._search.map.view, *(c.view for c in choices))], np.int64)
        left = self._cost_left(views, _numbers(valued.best.view))
        if left[0] <= NEAR:
            return out
        with np.errstate(invalid="ignore"):  # neither here nor there is a way
            nearer = (left[0] - left[1:]) / self._cost_of_going(views[1:])
        return np.nan_to_num(np.clip(nearer, NOTHING, 1.0), nan=NOTHING).astype(np.float32)

    def _cost_of_going(self, views: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n,) from here to views (n, 4) of node, heading and pitch, and of looking there; infinite without a way."""
        known, planner, costs = self._search.map, self._search.planner, self._search.viewpoints.costs
        i, j, heading, pitch_deg = views.T
        steps, moves = planner.steps[i, j, heading].astype(float), planner.moves[i, j, heading]
        turns = steps - moves + np.abs(pitch_deg - known.view.pitch_deg) / 30.0
        return np.where(steps < UNREACHED, moves + costs.turn * turns + costs.overhead, np.inf)

    def _cost_left(self, views: NDArray[np.int64], goal: tuple[int, int, int, int]) -> NDArray[np.float64]:
        """(n,) from views (n, 4) to a goal, and of looking there: moves by the true floor, turns at least.

        0 of the goal itself, infinite without a way.
        """
        costs = self._search.viewpoints.costs
        (i, j), (to_i, to_j) = (self._frame.nodes(*(at - HALF).T) for at in (views[:, :2], np.array([goal[:2]])))
        inside = (i >= 0) & (i < self._free.shape[0]) & (j >= 0) & (j < self._free.shape[1])
        moves = np.full(len(views), np.inf)
        far = distances(self._free, [(int(to_i[0]), int(to_j[0]))])[i[inside], j[inside]]
        moves[inside] = np.where(far >= 0, far, np.inf)
        turned = np.abs(views[:, 2] - goal[2]) % 4
        turns = np.minimum(turned, 4 - turned) + np.abs(views[:, 3] - goal[3]) / 30.0
        return moves + costs.turn * turns + np.where((moves > 0) | (turns > 0), costs.overhead, 0.0)


def _numbers(view: View) -> tuple[int, int, int, int]:
    """Node, heading and pitch."""
    return view.i, view.j, view.heading, view.pitch_deg
