"""The memory of a robot that keeps its map and where it saw things."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.core.files import sha256_file
from ucon.lives.clock import N_SLOTS, time_of
from ucon.memory.log_file import load_log, save_log
from ucon.memory.map_memory import MapMemory
from ucon.memory.place_model import Model, PlaceModel
from ucon.memory.protocol import Info, Observation
from ucon.memory.recalled import Recalled
from ucon.memory.sighting_log import SightingLog
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.map_kernels import look
from ucon.perception.mapping.semantic_map import camera_of, frame_depth
from ucon.perception.places.affordances import sight_range_m
from ucon.perception.places.hollows import ALL_OPEN


class SightingsMemory(MapMemory):
    """Remembers where things were, and where they were not; see :mod:`ucon.memory.place_model`."""

    def __init__(self, model: Model | None = None, keep: str | None = None, given: str | None = None) -> None:
        """Start without a home.

        Args:
            model: says where a thing is, from what was seen of it; :class:`ucon.memory.place_model.PlaceModel` by
                default.
            keep: folder to which each life's sightings are written after every request; None: they are not.
            given: folder of such files, with which lives begin; None: they begin without any.
        """
        super().__init__()
        self.log = SightingLog()
        self._keep, self._given = (None if folder is None else Path(folder) for folder in (keep, given))
        self._home: str | None = None
        self._model = model or PlaceModel()
        self.name = f"map and {self._model.name}"
        self._time = -1
        # Remembered places as this request begins, n in all: name and number, point, reach, and 1 until it was shown.
        self._of: list[tuple[str, int]] = []
        self._xyz, self._reach_m, self._unshown = np.zeros((0, 3)), np.zeros(0), np.zeros(0)
        self._hollow, self._faces = np.zeros((0, 6)), np.zeros(0, np.uint8)

    def fingerprint(self) -> str:
        """Hash of the files with which lives begin; "" without any."""
        files = [] if self._given is None else sorted(self._given.glob("*.json"))
        return "".join(sha256_file(path)[:16] for path in files)

    def begin(self, info: Info) -> dict[str, Any]:
        """The info for the agent's reset, with ``kept_map``, and with ``recalled`` where the target was seen before."""
        day, weekday, slot = info["clock"]
        self._time = time_of(day, slot)
        self._model.begin((weekday - day) % 7)
        if self._home is None:
            self._home = str(info["episode"]).rpartition("/")[0]
            if self._given is not None:
                self.log = load_log(self._given / _file_of(self._home), self._home)
        if (last := self.log.last()) > self._time:
            raise DataError(f"life {self._home}: it is day {day}, and the memory goes on to day {last // N_SLOTS}")
        self._watch()
        known, target = super().begin(info), str(info["target"])
        thing = self.log.things.get(target)
        if thing is None:
            return known
        return known | {"recalled": Recalled(thing.places, self._model.now(thing, self._time))}

    def look(self, observation: Observation, info: Info) -> None:
        """Note which remembered places the frame shows."""
        super().look(observation, info)
        assert self.map is not None
        depth = self.map.body.farthest(frame_depth(observation, info))
        camera = camera_of(self.map.view, depth, self.map.body)
        active = (self._unshown > 0.0) & (depth_along(self._xyz, camera) <= self._reach_m)
        if active.any():
            look(depth, camera, np.inf, self._xyz, self._hollow, self._faces, active, self._unshown, 0.0)

    def _watch(self) -> None:
        """Begin to note which of the remembered places frames show."""
        things = self.log.things
        self._of = [(name, place) for name, thing in things.items() for place in range(len(thing.places))]
        n = len(self._of)
        self._xyz = np.concatenate([np.zeros((0, 3)), *(thing.places for thing in things.values())])
        self._reach_m, self._unshown = np.array([sight_range_m(name) for name, _ in self._of]), np.ones(n)
        self._hollow, self._faces = np.zeros((n, 6)), np.full(n, ALL_OPEN, np.uint8)

    def end(self) -> None:
        """Enter what this request showed into the log."""
        assert self.map is not None
        known, book = self.map, catalogue()
        for name, tracks in known.instances.items():
            if name not in book or book[name].role != "movable":
                continue
            seen = [track for track in tracks if known.last_seen[track] >= 0 and known.seen(track)]
            if seen:
                box = known.box[max(seen, key=lambda track: (int(known.last_seen[track]), -track))]
                self.log.saw(name, 0.5 * (box[:3] + box[3:]), self._time)
        for row in np.flatnonzero(self._unshown == 0.0).tolist():
            name, place = self._of[row]
            if self.log.things[name].seen[-1:] != [(self._time, place)]:
                self.log.missed(name, place, self._time)
        if self._keep is not None:
            assert self._home is not None
            save_log(self.log, self._keep / _file_of(self._home), self._home)


def depth_along(xyz: NDArray[np.float64], camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Optical depth (n,) of points (n, 3) before a camera (8,), metres; below 0 behind it."""
    x, y, z, c, s, cp, sp, _ = camera
    return np.asarray(cp * (c * (xyz[:, 0] - x) + s * (xyz[:, 1] - y)) + sp * (xyz[:, 2] - z))


def _file_of(home: str) -> str:
    """Name of the file of a life's memory."""
    return f"{home.replace('/', '-').replace(':', '-')}.json"
