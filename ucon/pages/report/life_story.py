"""A life as a report shows it: its days, where each thing was, and where a robot believed it to be. Privileged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.kept_memories import NEAR_M, Truth
from ucon.lives.life import Life
from ucon.lives.request_record import BelievedPlace
from ucon.lives.timeline import Timeline
from ucon.pages.report.life_records import row_of
from ucon.sim.cache import load_house
from ucon.task.spoken import spoken_place


def head_of(life: Life) -> dict[str, Any]:
    """Facts to choose a life by: home, people, first weekday (0: Monday), season, occasions, and day of the change."""
    return {
        "id": life.id,
        "scene": life.scene,
        "users": life.users,
        "days": life.days,
        "weekday": life.first_weekday,
        "season": life.season,
        "occasions": [list(occasion) for occasion in life.occasions],
        "change": life.change_day,
    }


@dataclass(frozen=True, eq=False)
class LifeStory:
    """Describes a life, and what robots believed in it."""

    truth: Truth

    @property
    def life(self) -> Life:
        """The life."""
        return self.truth.life

    def things(self) -> list[dict[str, Any]]:
        """The possessions.

        Returns:
            For each, its ``name``, whether its habits ``change``, its ``places`` in words, which of them are
            ``mistakes``, and where it is ``at``: [time, place] at the first time and whenever the place changes.
        """
        at = Timeline(self.life).at
        return [
            {
                "name": one.category,
                "change": bool(one.later) and self.life.change_day is not None,
                "places": self.words(k),
                "mistakes": [number for number, place in enumerate(one.places) if not place.origins],
                "at": _changes(at[:, k]),
            }
            for k, one in enumerate(self.life.possessions)
        ]

    def words(self, possession: int) -> list[str]:
        """The places of a possession in words; to tell equal ones apart, the room is added, then a number."""
        rooms = load_house(self.life.scene).spec.rooms
        places = self.life.possessions[possession].places
        words = [spoken_place(*spot) for spot in self.truth.spots[possession]]
        in_rooms = [
            f"{text}, {rooms[place.object.room].name.replace('_', ' ')}"
            for text, place in zip(words, places, strict=True)
        ]
        return _numbered(_unlike(words, in_rooms))

    def rows(self, records: Sequence[EpisodeRecord]) -> list[dict[str, Any]]:
        """The requests of a run in this life.

        Args:
            records: of the run, all of this life.

        Returns:
            :func:`ucon.pages.report.life_records.row_of` of each in order, with the ``user`` who asks, and, for a
            robot that remembers places, those that it ``believed``: number of the nearest place of the thing (-1 where
            none is within 0.6 m), probability, and words.
        """
        number = {one.category: k for k, one in enumerate(self.life.possessions)}
        found = []
        for record in records:
            row = row_of(record)
            row["user"] = self.life.requests[row["request"]].user
            if record.believed is not None:
                row["believed"] = held(record.believed, self.truth.xyz[number[record.target]])
            found.append(row)
        return sorted(found, key=lambda row: row["request"])


def held(believed: Sequence[BelievedPlace], places: NDArray[np.float64]) -> list[list[Any]]:
    """Believed places, matched to the true ones.

    Args:
        believed: of a request.
        places: (P, 3) true places of the thing, metres in the frame of the dock.

    Returns:
        For each: number of the nearest true place, -1 where none is within 0.6 m; probability; words.
    """
    found: list[list[Any]] = []
    for place in believed:
        away = np.linalg.norm(places - (place.x, place.y, place.z), axis=1)
        row = int(away.argmin()) if away.min() <= NEAR_M else -1
        found.append([row, round(place.p, 3), place.words])
    return found


def _changes(places: NDArray[np.int16]) -> list[list[int]]:
    """(time, place) at the first time, and at each time at which a thing is elsewhere than before."""
    first = [True, *(places[1:] != places[:-1])]
    return [[int(time), int(places[time])] for time in np.flatnonzero(first)]


def _unlike(texts: Sequence[str], longer: Sequence[str]) -> list[str]:
    """The texts, or the longer ones in place of equal texts."""
    count = Counter(texts)
    return [long if count[text] > 1 else text for text, long in zip(texts, longer, strict=True)]


def _numbered(texts: Sequence[str]) -> list[str]:
    """The texts, with numbers added to equal ones."""
    count, seen = Counter(texts), Counter[str]()
    found = []
    for text in texts:
        seen[text] += 1
        found.append(f"{text} ({seen[text]})" if count[text] > 1 else text)
    return found
