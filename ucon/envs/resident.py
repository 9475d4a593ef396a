"""``UcONResident-v0``: a robot that lives in a home for days and is asked for things."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, SupportsFloat, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, EpisodeError, brief
from ucon.core.sharing import PartlyShared
from ucon.envs.knowledge import HabitSource
from ucon.envs.options import checked_action, returned_info, with_texts
from ucon.envs.ucon_env import Obs, UcONEnv
from ucon.habits.book import contexts_book
from ucon.lives.asking import Asking
from ucon.lives.check_life import check_life_home
from ucon.lives.clock import day_and_slot
from ucon.lives.life import Life
from ucon.lives.request_record import LifeFacts
from ucon.lives.sets import load_lives
from ucon.lives.sightings import LastSeen
from ucon.sim.cache import load_house
from ucon.task.actions import Action
from ucon.task.episode import Episode, Start
from ucon.task.rules import PAPER, task_rules

#: Rows of habits in observations: two entries for each of 40 possessions, and habits given later.
MAX_HABITS = 2048
#: Keys of info about the request, which are left out on a patrol.
_OF_REQUESTS = ("habits", "habit_rows", "context", "told", "reranking", "privileged")


class UcONResidentEnv(PartlyShared, gym.Env[Obs, int]):
    """Find what the people of a home ask for, day after day.

    ### Description
    A robot lives in a home. Four times a day somebody asks it for a thing, and it has 300 steps to find it. In between,
    people use their things and put them elsewhere, following their habits and the context, sometimes by mistake; on one
    day a part of the habits may change. The robot starts at its dock in the morning and otherwise where it stopped. It
    sees nothing between requests. One episode is one life.

    ### Action space
    That of ``UcON-v0``. Done ends the request.

    ### Observation space
    That of ``UcON-v0``, with ``pose`` relative to the dock for the whole life, ``step`` counted from 0 at every
    request, and these entries besides:
    | key | space | meaning |
    |---|---|---|
    | clock | int64 (3,) | day from 0, weekday (0: Monday), slot (0: morning, 1: midday, 2: evening) |
    | request | int64 (1,) | number of the request, from 0 |

    ### Info
    That of ``UcON-v0``. At the start of every request it is the info of a reset, with ``new_request`` True, ``clock``
    as in the observation, and ``habit_days``, the day on which each habit was given. Once a request has ended,
    ``request_record`` has its metrics and, as ``life``, :class:`ucon.lives.request_record.LifeFacts`, and
    ``is_success`` says whether the thing was found.

    ### Patrol
    With ``patrol`` above 0 the robot may look around for that many steps before the first request of each day, starting
    at its dock; the time is the slot of that request. Meanwhile nothing is asked for (``target`` is "" in info and
    zeros in observations, no habits are given), ``info["patrol"]`` has the number of steps left, and rewards are 0.
    Done ends the patrol earlier. The request begins where the robot then stands.

    ### Rewards
    Those of ``UcON-v0`` for each request.

    ### Termination
    The life ends after its last request.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 6}  # noqa: RUF012 (Gymnasium's own name and type)
    _shared: ClassVar[frozenset[str]] = frozenset({"lives", "life", "_asking", "spec", "metadata"})

    options_of = UcONEnv
    """The environment whose options this one accepts besides its own."""

    def __init__(
        self,
        lives: str | Path | Sequence[Life] = "lives_mini",
        *,
        told: bool = True,
        stale: bool = True,
        patrol: int = 0,
        source: HabitSource | None = None,
        max_habits: int = MAX_HABITS,
        texts: bool | None = None,
        **options: Any,
    ) -> None:
        """Make the environment.

        Args:
            lives: name of a set, a file, or lives.
            told: whether changed habits are given from the day of the change on, or never.
            stale: whether the habits that they replace are still given from then on.
            patrol: steps a day to look around before the first request.
            source: gives the habits; by default the habit book with its second part.
            max_habits: rows of habits in observations.
            texts: whether info holds texts; None: yes except in worker processes.
            **options: options of ``UcON-v0``.

        Raises:
            ConfigError: an option has an unknown value.
            EpisodeError: there are no such lives.
        """
        self.lives = load_lives(lives) if isinstance(lives, str | Path) else tuple(lives)
        if not self.lives:
            raise EpisodeError("no lives: expected at least one; name a set (lives_mini, lives_test) or give a path")
        if "episodes" in options:
            raise ConfigError("env.episodes: a resident plays lives; give env.lives=SET and leave episodes out")
        if type(patrol) is not int or not 0 <= patrol < task_rules(str(options.get("task", PAPER.name))).max_steps:
            raise ConfigError(
                f"env.patrol={brief(patrol)}: expected steps a day, from 0 to fewer than a request may take"
            )
        self._patrol, self._left = patrol, 0
        self._told, self._stale, self._texts = told, stale, with_texts(texts)
        source = source or HabitSource(contexts_book())
        first = Asking(self.lives[0], source.dataset, told=told, stale=stale)
        self.search_env = UcONEnv(
            [first.episode(0, self.lives[0].dock)], source=source, max_habits=max_habits, texts=True, **options
        )
        self.render_mode = self.search_env.render_mode
        self.action_space = self.search_env.action_space
        most = max(len(life.requests) for life in self.lives)
        days = max(life.days for life in self.lives)
        self.observation_space = spaces.Dict(
            {
                **cast("spaces.Dict", self.search_env.observation_space).spaces,
                "clock": spaces.Box(0, np.array([days, 6, 2]), (3,), np.int64),
                "request": spaces.Box(0, most, (1,), np.int64),
            }
        )
        self._asking: Asking | None = None
        self._number = -1

    @property
    def source(self) -> HabitSource:
        """Source of the habits of every request."""
        return self.search_env.source

    @property
    def episode(self) -> Episode:
        """The running request as an episode. Privileged."""
        return self.search_env.episode

    @property
    def facts(self) -> LifeFacts:
        """The running request within the life. Privileged."""
        return self._facts

    @property
    def request(self) -> int:
        """Number of the running request, from 0."""
        return self._number

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start a life at its first request.

        Args:
            seed: draws the life, unless one is given.
            options: ``life``, a Life, an id or an index; ``habit_level``, the level for this life only.

        Returns:
            Observation and info; see the class.

        Raises:
            EpisodeError: no such life, or it does not fit its home or the habits in use.
        """
        super().reset(seed=seed)
        self._asking = None  # after a failed reset nothing can be continued
        self.life = self._choose(options or {})
        check_life_home(self.life, load_house(self.life.scene))
        self._asking = Asking(self.life, self.source.dataset, told=self._told, stale=self._stale)
        self._level = {"habit_level": level} if (level := (options or {}).get("habit_level")) else {}
        self._seen = LastSeen(self._asking.timeline)
        self._number, self._been = 0, False
        observation, info = self._begin(self.life.dock)
        return observation, returned_info(info, texts=self._texts)

    def step(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Carry out one action; if it ends a request, the next one begins.

        Args:
            action: 0 to 6, see :class:`ucon.task.actions.Action`.

        Returns:
            Observation, reward, terminated, truncated, info; see the class.

        Raises:
            EpisodeError: before the first reset, or after the end of a life.
            ActionError: not an action; nothing was done.
        """
        if self._asking is None:
            raise EpisodeError("step before reset: call reset() first")
        if self._number >= len(self.life.requests):
            raise EpisodeError(f"life {self.life.id} is over: call reset() first")
        if self._left:
            return self._look_around(action)
        observation, reward, done, truncated, info = self.search_env.step(action)
        if not (done or truncated):
            self._look()
            return self._with_clock(observation), reward, False, False, returned_info(info, texts=self._texts)
        metrics, success = info.pop("episode_metrics"), info.pop("is_success")
        ended = {"request_record": metrics | {"life": self._facts.to_json()}, "is_success": success}
        self._look()
        self._number += 1
        over = self._number == len(self.life.requests)
        if not over:
            observation, info = self._begin(self._stopped())
        else:
            observation = self._with_clock(observation)
        return observation, reward, over, False, returned_info(info | ended, texts=self._texts)

    def action_masks(self) -> NDArray[np.bool_]:
        """(7,) bool, all True; see ``UcON-v0``."""
        return self.search_env.action_masks()

    def render(self) -> NDArray[np.uint8] | None:
        """The current frame; see ``UcON-v0``."""
        return self.search_env.render()

    def close(self) -> None:
        """Release the renderer."""
        self.search_env.close()

    def _look_around(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Carry out one action of a patrol; the last one begins the request."""
        ends = checked_action(action, len(Action)) == Action.DONE
        self._left -= 1
        if not ends:
            observation, _, _, _, info = self.search_env.step(action)
            self._look()
            if self._left:
                observation, info = self._nothing_asked(observation, info)
                return observation, 0.0, False, False, returned_info(info, texts=self._texts)
        self._left, pose = 0, self.search_env.search.pose
        observation, info = self._ask(Start(pose.i, pose.j, pose.heading))
        return observation, 0.0, False, False, returned_info(info, texts=self._texts)

    def _begin(self, at: Start) -> tuple[Obs, dict[str, Any]]:
        """Begin the current request, or the patrol before the first request of a day, with the robot at a node."""
        if not (self._patrol and self._is_first):
            return self._ask(at)
        self._left = self._patrol
        observation, info = self._arrive(at)
        self._look()
        return self._nothing_asked(observation, info)

    def _arrive(self, at: Start) -> tuple[Obs, dict[str, Any]]:
        """Put the robot at a node, or near it if that is blocked, in the home as it is at the current request."""
        assert self._asking is not None
        number, asking = self._number, self._asking
        episode = asking.episode(number, asking.standing(number, at))
        options = {"episode": episode, "frame": self.life.dock, "same_home": self._been} | self._level
        self._been = True
        return self.search_env.reset(options=options)

    def _ask(self, at: Start) -> tuple[Obs, dict[str, Any]]:
        """Begin the current request."""
        assert self._asking is not None
        number, asking = self._number, self._asking
        observation, info = self._arrive(at)
        self._facts = self._seen.facts(number, obeys=asking.obeys(number))
        if "privileged" in info:
            last_seen = self._seen.last(self.life.requests[number].possession)
            info["privileged"] |= {"life": self.life, "request": number, "last_seen": last_seen}
        self._look()
        days = dict(asking.told_entries(day_and_slot(self.life.requests[number].time)[0]))
        dataset = self.source.dataset
        info["habit_days"] = tuple(
            days.get(dataset.entry_of(row).id, 0) if row < len(dataset) else 0 for row in info["habit_rows"]
        )
        observation = self._with_clock(observation)
        clock = tuple(observation["clock"].tolist())
        return observation, info | {"new_request": True, "request": number, "clock": clock}

    def _nothing_asked(self, observation: Obs, info: dict[str, Any]) -> tuple[Obs, dict[str, Any]]:
        """A frame of a patrol: without target and habits."""
        observation = self._with_clock(observation)
        observation |= {name: np.zeros_like(observation[name]) for name in ("target", "habits", "habits_mask")}
        shown = {name: value for name, value in info.items() if name not in _OF_REQUESTS}
        clock = tuple(observation["clock"].tolist())
        return observation, shown | {"target": "", "habits": (), "patrol": self._left, "clock": clock}

    @property
    def _is_first(self) -> bool:
        """Whether the current request is the first one of its day."""
        if self._number == 0:
            return True
        before, now = (day_and_slot(self.life.requests[k].time)[0] for k in (self._number - 1, self._number))
        return now > before

    def _stopped(self) -> Start:
        """Where the robot is for the next request: at the dock in the morning, otherwise where it stopped."""
        pose = self.search_env.search.pose
        return self.life.dock if self._is_first else Start(pose.i, pose.j, pose.heading)

    def _look(self) -> None:
        """Note which possessions the robot sees now."""
        request = min(self._number, len(self.life.requests) - 1)
        self._seen.look(self.search_env.search.counts, self.life.requests[request].time, self.search_env.rules)

    def _with_clock(self, observation: Obs) -> Obs:
        """The observation with clock and number of the request."""
        number = min(self._number, len(self.life.requests) - 1)
        day, slot = day_and_slot(self.life.requests[number].time)
        clock = np.array([day, self.life.weekday(day), slot])
        return observation | {"clock": clock, "request": np.array([number])}

    def _choose(self, options: dict[str, Any]) -> Life:
        """The life of ``options``, else one drawn from the seed."""
        wanted = options.get("life")
        if wanted is None:
            return self.lives[int(self.np_random.integers(len(self.lives)))]
        if isinstance(wanted, Life):
            return wanted
        if isinstance(wanted, str):
            found = next((life for life in self.lives if life.id == wanted), None)
            if found is None:
                raise EpisodeError(f"no life '{wanted}' among the {len(self.lives)} of this environment")
            return found
        if not 0 <= int(wanted) < len(self.lives):
            raise EpisodeError(f"life index {wanted}, expected 0 to {len(self.lives) - 1}")
        return self.lives[int(wanted)]
