"""How well a robot got to know its household: its stored sightings against the life that it lived.

Two things are measured: the habits that the robot found out (which share of them is true, and which share of the true
habits of known things was found), and its memory's predictions of tomorrow's places, against baselines of remembering.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ucon.envs.frame import StartFrame
from ucon.evaluation.figures.intervals import Interval, mean_interval, paired_difference
from ucon.lives.clock import N_SLOTS, time_of
from ucon.lives.life import Life
from ucon.lives.meeting import object_boxes
from ucon.lives.timeline import Timeline
from ucon.memory.acquired import acquired_habits
from ucon.memory.place_model import Model, PlaceModel
from ucon.memory.sighting_log import SeenThing, SightingLog
from ucon.memory.simple_models import LastSeen, MostSeen
from ucon.sim.cache import load_house

#: A thing counts as being at a known place that is at most this far away, metres.
NEAR_M: Final = 0.6
#: Probability of a thing's true place, given only that it is at none of its known places.
ELSEWHERE_P: Final = 0.1
_LEAST = 1e-3


@dataclass(frozen=True, eq=False)
class Truth:
    """True places of a life's possessions. Privileged.

    Attributes:
        life: the life.
        xyz: for each possession, (P, 3) middles of its places in the frame of the dock, metres.
        spots: for each possession, relation and anchor category of its places.
    """

    life: Life
    xyz: tuple[NDArray[np.float64], ...]
    spots: tuple[tuple[tuple[str, str], ...], ...]

    @classmethod
    def of(cls, life: Life) -> Truth:
        """The truth of a life."""
        house, frame = load_house(life.scene), StartFrame(life.dock)
        names = (*house.categories, *(one.category for one in life.fixed))
        xyz, spots = [], []
        for one in life.possessions:
            boxes = [object_boxes(place.object) for place in one.places]
            middles = [0.5 * (box[:, :3].min(0) + box[:, 3:].max(0)) for box in boxes]
            xyz.append(np.array([frame.point(middle, house.grid) for middle in middles]))
            spots.append(tuple((place.object.relation, names[place.object.anchor]) for place in one.places))
        return cls(life, tuple(xyz), tuple(spots))

    def habits(self, possession: int, day: int) -> frozenset[tuple[str, str]]:
        """Relation and anchor of the places where a possession is put by habit on a day."""
        entries = set(self.life.entries_at(possession, day))
        places = zip(self.life.possessions[possession].places, self.spots[possession], strict=True)
        return frozenset(spot for place, spot in places if any(name in entries for name, _ in place.origins))


@dataclass
class Known:
    """Figures of what several robots knew about their households; each value with the id of its life.

    Attributes:
        written: for every sentence at the end of a life, whether it is a habit then.
        covered: for every habit by which a known thing is kept at the end, whether a sentence states it.
        tomorrow: by model, the log-likelihood of each known thing's place in every slot of the next day.
    """

    written: list[tuple[str, bool]] = field(default_factory=list)
    covered: list[tuple[str, bool]] = field(default_factory=list)
    tomorrow: dict[str, list[tuple[str, float]]] = field(default_factory=dict)

    def add(self, life: Life, log: SightingLog) -> None:
        """Add the sightings of one robot.

        Args:
            life: the life that it lived.
            log: its sightings at the end.
        """
        truth, timeline = Truth.of(life), Timeline(life)
        number = {one.category: k for k, one in enumerate(life.possessions)}
        own = {name: thing for name, thing in log.things.items() if name in number}
        models: list[Model] = [PlaceModel(), MostSeen(), LastSeen()]
        for model in models:
            model.begin(life.first_weekday)
        self._habits(truth, own, number, models[0])
        for day in range(life.days - 1):
            for name, thing in own.items():
                known = until(thing, time_of(day + 1, 0))
                if known.seen:
                    self._tomorrow(models, known, truth.xyz[number[name]], timeline.at[:, number[name]], life, day + 1)

    def _habits(self, truth: Truth, own: Mapping[str, SeenThing], number: Mapping[str, int], model: Model) -> None:
        life, end = truth.life, time_of(truth.life.days, 0)
        for name, thing in own.items():
            kept = truth.habits(number[name], life.days - 1)
            said: set[tuple[str, str]] = set()
            for habit in acquired_habits(thing, model.first(thing, end), life.first_weekday):
                right = kept.intersection(habit.spot)
                self.written.append((life.id, bool(right)))
                said |= right
            self.covered += [(life.id, spot in said) for spot in sorted(kept)]

    def _tomorrow(
        self, models: Sequence[Model], known: SeenThing, xyz: NDArray[np.float64], at: NDArray[np.int16], life: Life,
        day: int,
    ) -> None:  # fmt: skip
        for slot in range(N_SLOTS):
            time = time_of(day, slot)
            for model in models:
                value = log_likelihood(model.now(known, time), known, xyz[int(at[time])])
                self.tomorrow.setdefault(model.name, []).append((life.id, value))

    def precision(self) -> Interval:
        """Share of the sentences that are habits."""
        return _interval(self.written)

    def recall(self) -> Interval:
        """Share of the habits of known things that a sentence states."""
        return _interval(self.covered)

    def likelihoods(self) -> dict[str, Interval]:
        """Mean log-likelihood of tomorrow's places, by model, in nats."""
        return {name: _interval(values) for name, values in self.tomorrow.items()}

    def better(self, first: str, second: str) -> Interval:
        """Difference of the log-likelihoods of two models, in nats."""
        one, other = self.tomorrow[first], self.tomorrow[second]
        return paired_difference([v for _, v in one], [v for _, v in other], clusters=[life for life, _ in one])

    def to_json(self) -> dict[str, Any]:
        """All figures as JSON data."""

        def row(value: Interval) -> dict[str, Any]:
            return {"mean": value.mean, "ci95": list(value.ci95), "n": value.n}

        names = list(self.tomorrow)
        return {
            "precision": row(self.precision()),
            "recall": row(self.recall()),
            "tomorrow": {name: row(value) for name, value in self.likelihoods().items()},
            "better": {name: row(self.better(names[0], name)) for name in names[1:]},
        }


def known_table(title: str, known: Known) -> Table:
    """The figures with their intervals over lives.

    Args:
        title: of the table.
        known: of the robots.
    """
    table = Table(title=title, title_justify="left")
    table.add_column("", no_wrap=True)
    table.add_column("n", justify="right")
    table.add_column("mean [95 %]", justify="right", no_wrap=True)
    rows = {"sentences that are habits": known.precision(), "habits that a sentence states": known.recall()}
    rows |= {f"tomorrow's places by {name}, nats": value for name, value in known.likelihoods().items()}
    names = list(known.tomorrow)
    rows |= {f"{names[0]} minus {name}, nats": known.better(names[0], name) for name in names[1:]}
    for name, value in rows.items():
        table.add_row(name, str(value.n), f"{value.mean:.3f} [{value.low:.3f}, {value.high:.3f}]")
    return table


def log_likelihood(p: NDArray[np.float64], thing: SeenThing, xyz: NDArray[np.float64]) -> float:
    """Log-likelihood of a thing's true place, in nats.

    Args:
        p: (n,) probability of its known places.
        thing: what is known about it.
        xyz: (3,) where it is, metres in the frame of the dock.
    """
    away = np.linalg.norm(thing.places - xyz, axis=1)
    here = float(p[away.argmin()]) if away.min() <= NEAR_M else (1.0 - float(p.sum())) * ELSEWHERE_P
    return float(np.log(max(here, _LEAST)))


def until(thing: SeenThing, time: int) -> SeenThing:
    """What was known about a thing before a time; its places are named as they were at the end."""
    seen = [(when, place) for when, place in thing.seen if when < time]
    count = max((place for _, place in seen), default=-1) + 1
    absent = [(when, place) for when, place in thing.absent if when < time and place < count]
    return SeenThing(thing.name, thing.places[:count], seen, absent, thing.spots[:count], thing.size[:count])


def examples(log: SightingLog, life: Life, count: int) -> Iterator[tuple[str, bool]]:
    """Some sentences of a robot at the end of a life, those with the most sightings first; whether each is a habit.

    Args:
        log: its sightings at the end.
        life: the life that it lived.
        count: number of sentences.
    """
    truth, model, end = Truth.of(life), PlaceModel(), time_of(life.days, 0)
    model.begin(life.first_weekday)
    number = {one.category: k for k, one in enumerate(life.possessions)}
    found = [
        habit
        for name, thing in log.things.items()
        if name in number
        for habit in acquired_habits(thing, model.first(thing, end), life.first_weekday)
    ]
    for habit in sorted(found, key=lambda habit: (-habit.times, habit.text))[:count]:
        yield habit.text, bool(truth.habits(number[habit.thing], life.days - 1).intersection(habit.spot))


def _interval(values: Sequence[tuple[str, float | bool]]) -> Interval:
    return mean_interval([float(value) for _, value in values], clusters=[life for life, _ in values])
