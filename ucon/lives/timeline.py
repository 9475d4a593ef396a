"""Where every possession is at any time of a life, and the home at that time."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.lives.clock import N_SLOTS
from ucon.lives.life import Life, Place
from ucon.sim.arrangement import Arrangement


class Timeline(Shared):
    """Places by time. Privileged.

    Possession k is instance ``house.n_instances + len(life.fixed) + k`` of the home at all times.
    """

    def __init__(self, life: Life) -> None:
        """Take a life."""
        self.life = life

    @cached_property
    def at(self) -> NDArray[np.int16]:
        """(3 * days, K) place of each of the K possessions at each time, after the moves of that slot."""
        life = self.life
        found = np.empty((N_SLOTS * life.days, len(life.possessions)), np.int16)
        now, moves = np.array(life.at_first, np.int16), iter(life.moves)
        move = next(moves, None)
        for time in range(len(found)):
            while move is not None and move.time == time:
                now[move.possession] = move.place
                move = next(moves, None)
            found[time] = now
        return found

    def place(self, possession: int, time: int) -> Place:
        """Where a possession is at a time."""
        return self.life.possessions[possession].places[int(self.at[time, possession])]

    def places(self, time: int) -> list[Place]:
        """Where all possessions are at a time."""
        return [one.places[int(k)] for one, k in zip(self.life.possessions, self.at[time], strict=True)]

    def arrangement(self, time: int) -> Arrangement:
        """The home at a time: the fixed objects, then the possessions."""
        life, places = self.life, self.places(time)
        blocked = {*life.fixed_blocked, *(cell for place in places for cell in place.blocked)}
        objects = (*life.fixed, *(place.object for place in places))
        return Arrangement(life.removed, objects, tuple(sorted(blocked)))
