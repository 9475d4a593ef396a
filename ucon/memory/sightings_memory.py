"""The memory of a robot that keeps its map and where it saw things."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import require_writable, sha256_file
from ucon.lives.clock import N_SLOTS, time_of
from ucon.lives.request_record import BelievedPlace
from ucon.memory.acquired import AcquiredHabit, acquired_habits, spoken, texts_of
from ucon.memory.earlier_looks import NEVER, Looking
from ucon.memory.log_file import load_log, log_name, save_log
from ucon.memory.looking_around import LookingAround
from ucon.memory.map_memory import MapMemory
from ucon.memory.naming import spot_of
from ucon.memory.patrol import Patrol, interest
from ucon.memory.place_model import Model, PlaceModel
from ucon.memory.protocol import Info, Observation
from ucon.memory.sighting_log import SeenThing, SightingLog
from ucon.memory.watching import Watching
from ucon.objects.catalogue import catalogue
from ucon.perception.belief.recalled import Recalled
from ucon.perception.mapping.semantic_map import SemanticMap, frame_depth
from ucon.perception.places.affordances import sight_range_m
from ucon.readers.anchor_reader import default_reader

#: Distance within which a place counts as looked at on a patrol, metres; that of a small thing.
_PATROL_REACH_M: Final = 2.1
#: Number of likeliest places that are recorded.
_TOLD: Final = 3
#: A thing that an imperfect detector recognised with this probability is later recognised by its place.
SURE: Final = 0.95
#: A sentence is about a thing if its relevance is above this.
ABOUT: Final = 0.5


class SightingsMemory(MapMemory):
    """Remembers where things were, and where they were not; see :mod:`ucon.memory.place_model`."""

    def __init__(
        self,
        model: Model | None = None,
        *,
        recalls: bool = True,
        acquires: bool = False,
        looks: bool = True,
        around: bool = True,
        keep: str | None = None,
        given: str | None = None,
    ) -> None:
        """Start without a home.

        Args:
            model: predicts where a thing is, from its sightings; by default
                :class:`ucon.memory.place_model.PlaceModel`.
            recalls: whether searches are given the map and the remembered places.
            acquires: whether searches are given the habits that the robot found out, as further sentences.
            looks: whether to remember which places were empty, wherever a thing can be.
            around: whether the robot looks around before it ends a request.
            keep: folder to which each life's sightings are written after every request; None: not written.
            given: folder of such files, with which lives begin; None: lives begin without memory.

        Raises:
            ConfigError: ``keep`` and ``given`` are the same folder, or ``keep`` is not writable.
        """
        super().__init__()
        self.log = SightingLog()
        self._keep, self._given = (None if folder is None else Path(folder) for folder in (keep, given))
        if self._keep is not None:
            if self._given is not None and self._keep.resolve() == self._given.resolve():
                raise ConfigError(f"memory: keep and given are both {brief(str(keep))}; choose another folder for keep")
            require_writable(self._keep / log_name(""))
        self._home: str | None = None
        self._model = model or PlaceModel()
        self._recalls, self._acquires = recalls, acquires
        self.uses_habits = recalls and self._model.uses_habits
        parts = {"map": recalls, self._model.name: recalls, "own habits": acquires}
        self.name = " and ".join(name for name, is_used in parts.items() if is_used)
        self._time, self._first_weekday = -1, 0
        self._watching = Watching(self.log)
        self._looking = Looking() if looks else None
        self._patrol: Patrol | None = None
        self._asked: Counter[str] = Counter()
        self._around = LookingAround() if around else None

    def fingerprint(self) -> str:
        """Hash of the files with which lives begin; "" without such files."""
        files = [] if self._given is None else sorted(self._given.glob("*.json"))
        return "".join(sha256_file(path)[:16] for path in files)

    def begin(self, info: Info) -> dict[str, Any]:
        """The info for the agent's reset, with the parts of the memory that it may use.

        These are ``kept_map``; ``recalled``, where the target was seen before and where not; ``habits_valid``; and
        habits that the robot found out, among the ``habits``.
        """
        if self._patrol is not None:  # the last frame of a patrol is the first one of the request
            self._patrol = None
            self.end()
        self._wake(info)
        self._asked[str(info["target"])] += 1
        if self._around is not None:
            self._around.begin(info)
        given = {**info, **self._kept(info)} if self._recalls else {**info, **self._unshared(info)}
        if self._acquires:
            own = self.habits(str(info["target"]))
            given["habits"] = (*given["habits"], *texts_of(own))
            given["habit_days"] = (*given.get("habit_days", ()), *(habit.last_day for habit in own))
            if "habits_valid" in given:
                given["habits_valid"] = np.append(given["habits_valid"], np.ones(len(own)))
        return given

    def patrol(self, observation: Observation, info: Info) -> int:
        """Look where the robot is unsure about things that are asked for; see :mod:`ucon.memory.patrol`."""
        if self._patrol is None:
            self._wake(info)
            known = super().begin(info)
            looked, when = (Looking() if self._looking is None else self._looking).begin(_PATROL_REACH_M)
            left = self._model.left(when, NEVER, self._time)
            self._patrol = Patrol(known, interest(self.log, self._model, self._time, self._asked, looked, left))
        action = self._patrol.act(observation, info)
        self._note(observation, info)
        return action

    def _wake(self, info: Info) -> None:
        """Note the time, and begin to watch the remembered places."""
        day, weekday, slot = info["clock"]
        self._time, self._first_weekday = time_of(day, slot), (weekday - day) % 7
        self._model.begin(self._first_weekday)
        if self._home is None:
            self._home = str(info["episode"]).rpartition("/")[0]
            if self._given is not None:
                self.log = load_log(self._given / log_name(self._home), self._home)
        if (last := self.log.last()) > self._time:
            later = f"it is day {day}, but the memory reaches to day {last // N_SLOTS}"
            raise DataError(f"life {self._home}: {later}; start with an earlier one")
        self._watching = Watching(self.log)

    def _unshared(self, info: Info) -> dict[str, Any]:
        """Begin a request in which the agent keeps its own map."""
        super().begin(info)
        if self._looking is not None:
            self._looking.begin(0.0)
        return {}

    def _kept(self, info: Info) -> dict[str, Any]:
        """The map, the remembered places, and which habits still hold."""
        known, target = {"kept_map": super().begin(info)["kept_map"]}, str(info["target"])
        thing = self.log.things.get(target, SeenThing(target))
        days = info.get("habit_days", ())
        news = days_of_news(target, tuple(info["habits"]), days)
        recalled = Recalled(thing.places, self._model.now(thing, self._time, news), tuple(thing.spots))
        self.believed = _likeliest(thing, recalled)
        if self._looking is not None:
            points, when = self._looking.begin(sight_range_m(target))
            last = thing.seen[-1][0] if thing.seen else NEVER
            recalled = replace(recalled, looked=points, left=self._model.left(when, last, self._time))
        assert self.map is not None
        if self.map.hypotheses is not None:
            recalled = replace(recalled, size=thing.size)
        if len(recalled.xyz) or len(recalled.looked):
            known["recalled"] = recalled
        if "reranking" not in info:
            known["habits_valid"] = self._model.valid(thing, self._time, news, days)
        return known

    def habits(self, name: str) -> list[AcquiredHabit]:
        """The habits of a thing that the robot found out, those seen most often first.

        Args:
            name: category of the thing.
        """
        thing = self.log.things.get(name, SeenThing(name))
        return acquired_habits(thing, self._model.first(thing, self._time), self._first_weekday)

    def look(self, observation: Observation, info: Info) -> None:
        """Note which places the frame shows."""
        if not self._recalls:
            assert self.map is not None
            self.map.update(observation, info)
        super().look(observation, info)
        self._note(observation, info)

    def _note(self, observation: Observation, info: Info) -> None:
        """Note which places a mapped frame shows."""
        assert self.map is not None
        depth = self.map.body.farthest(frame_depth(observation, info))
        if self._looking is not None:
            self._looking.look(self.map, depth)
        self._watching.look(self.map, depth)

    def act(self, action: int, observation: Observation) -> int:
        """The agent's action; before Done, the robot looks around."""
        return action if self._around is None else self._around.act(action, int(observation["step"][0]))

    def end(self) -> None:
        """Enter what this request showed into the log: movable things, and things that were asked for."""
        assert self.map is not None
        known, book = self.map, catalogue()
        for name, tracks in known.instances.items():
            is_kept = name in self._asked or name in self.log.things
            if name not in book or not (is_kept or book[name].role == "movable"):
                continue
            seen = [track for track in tracks if known.last_seen[track] >= 0 and known.seen(track)]
            if seen:
                newest = max(seen, key=lambda track: (int(known.last_seen[track]), -track))
                box = known.box[newest]
                size = box[3:] - box[:3] if _is_sure(known, name, newest) else None
                self.log.saw(name, 0.5 * (box[:3] + box[3:]), self._time, spot_of(known, name, box), size)
        stands = self._watching.stands
        for name, place in self._watching.shown:
            last = self.log.things[name].seen[-1]
            if last == (self._time, place):
                continue
            if (name, place) not in stands:
                self.log.missed(name, place, self._time)
            elif last[0] < self._time and last[1] == place:  # the thing last seen there is still there
                self.log.saw_again(name, place, self._time)
        if self._looking is not None:
            self._looking.end(self._time)
        if self._keep is not None:
            assert self._home is not None
            save_log(self.log, self._keep / log_name(self._home), self._home)


def _is_sure(known: SemanticMap, name: str, track: int) -> bool:
    """Whether an imperfect detector recognised a thing well enough to recognise it by its place later."""
    if known.hypotheses is None:
        return False
    return float(known.hypotheses.named((name,), known.n_tracks)[track, 0]) >= SURE


def _likeliest(thing: SeenThing, recalled: Recalled) -> tuple[BelievedPlace, ...]:
    """The likeliest places of a thing, as recorded."""
    rows = np.argsort(-recalled.p, kind="stable")[:_TOLD]
    return tuple(
        BelievedPlace(
            spoken(thing.spots[k]), round(float(recalled.p[k]), 4), *(round(float(v), 3) for v in thing.places[k])
        )
        for k in rows.tolist()
        if recalled.p[k] > 0.0
    )


def days_of_news(target: str, habits: tuple[str, ...], days: Sequence[int]) -> tuple[int, ...]:
    """Days after the first on which habits of a thing were given.

    Args:
        target: the thing.
        habits: sentences.
        days: day on which each sentence was given.
    """
    if not any(days):
        return ()
    about = default_reader().read(target, habits).relevance > ABOUT
    return tuple(sorted({day for day, is_about in zip(days, about, strict=True) if day and is_about}))
