"""Drift: the log-likelihood of the places of things whose habits change, by days since the change.

It is measured for a robot that is told of the change, for one that is not, and for one that expects no changes. The
loss on the day of the change, and the share of it that is recovered later, show what a change costs a memory.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ucon.core.rng import stream
from ucon.evaluation.figures.intervals import RESAMPLES, Interval, mean_interval
from ucon.evaluation.kept_memories import Truth, log_likelihood, until
from ucon.lives.clock import N_SLOTS, day_and_slot, time_of
from ucon.lives.life import Life
from ucon.lives.timeline import Timeline
from ucon.memory.place_model import PlaceModel, PlaceWeights
from ucon.memory.sighting_log import SightingLog

#: Days before the change, which serve as the baseline, and days that are followed from the change on.
BEFORE, AFTER = 4, 7
TOLD, UNTOLD, UNAWARE = "told of the change", "not told", "reckons with no change"
#: By name of the robot: weights of its place model, and whether it is told of the change.
ROBOTS: Final = {
    TOLD: (PlaceWeights(), True),
    UNTOLD: (PlaceWeights(), False),
    UNAWARE: (PlaceWeights(change=0.0, news=0.0), False),
}


@dataclass
class Drift:
    """Values of several lives.

    Attributes:
        values: by robot and day since the change, (life, log-likelihood) of each changed thing in each slot.
    """

    values: dict[str, dict[int, list[tuple[str, float]]]] = field(
        default_factory=lambda: {name: {day: [] for day in range(-BEFORE, AFTER)} for name in ROBOTS}
    )

    def add(self, life: Life, log: SightingLog) -> None:
        """Add the sightings of one robot; a life in which nothing changes adds nothing.

        Args:
            life: the life that it lived.
            log: its sightings at the end.
        """
        if life.change_day is None:
            return
        truth, timeline = Truth.of(life), Timeline(life)
        for name, (weights, is_told) in ROBOTS.items():
            model = PlaceModel(weights)
            model.begin(life.first_weekday)
            for time, number in _changed(life, log):
                thing = until(log.things[life.possessions[number].category], time)
                if not thing.seen:
                    continue
                day = day_and_slot(time)[0] - life.change_day
                told = (life.change_day,) if is_told and day >= 0 else ()
                p, xyz = model.now(thing, time, told), truth.xyz[number][int(timeline.at[time, number])]
                self.values[name][day].append((life.id, log_likelihood(p, thing, xyz)))

    @property
    def lives(self) -> list[str]:
        """Lives with something that changed, in order."""
        days = self.values[TOLD].values()
        return sorted({life for values in days for life, _ in values})

    def by_day(self, name: str) -> dict[int, Interval]:
        """Mean log-likelihood by day since the change, in nats.

        Args:
            name: of a robot.
        """
        return {
            day: mean_interval([v for _, v in values], clusters=[life for life, _ in values])
            for day, values in self.values[name].items()
            if values
        }

    def made_good(self, name: str, day: int) -> Interval:
        """Share of the first day's loss that is recovered on a later day; 1: all of it. The interval resamples lives.

        Args:
            name: of a robot.
            day: since the change, from 1 up.
        """
        lives, draw = self.lives, stream(0, "drift", name, day)
        periods = (range(-BEFORE, 0), (0,), (day,))
        sums = np.array([[self._sums(name, life, days) for days in periods] for life in lives])  # (L, 3, 2)

        def share(rows: NDArray[np.int64]) -> float:
            total = sums[rows].sum(0)
            usual, first, then = total[:, 0] / np.maximum(total[:, 1], 1.0)
            return float((then - first) / (usual - first))

        found = [share(draw.integers(len(lives), size=len(lives))) for _ in range(RESAMPLES)]
        low, high = np.quantile(found, [0.025, 0.975])
        return Interval(share(np.arange(len(lives))), float(low), float(high), len(lives))

    def _sums(self, name: str, life: str, days: Sequence[int]) -> tuple[float, float]:
        """Sum and number of the values of a life on some days."""
        values = [v for day in days for of, v in self.values[name][day] if of == life]
        return float(sum(values)), float(len(values))

    def to_json(self) -> dict[str, Any]:
        """All figures as JSON data."""

        def row(value: Interval) -> dict[str, Any]:
            return {"mean": value.mean, "ci95": list(value.ci95), "n": value.n}

        return {
            name: {
                "by_day": {str(day): row(value) for day, value in self.by_day(name).items()},
                "made_good": {str(day): row(self.made_good(name, day)) for day in range(1, AFTER)},
            }
            for name in ROBOTS
        }


def _changed(life: Life, log: SightingLog) -> Iterator[tuple[int, int]]:
    """Time and possession number, for each changed thing that was ever seen and each time around the change."""
    assert life.change_day is not None
    first, last = max(life.change_day - BEFORE, 1), min(life.change_day + AFTER, life.days)
    for number, one in enumerate(life.possessions):
        if one.later and one.category in log.things:
            for time in range(time_of(first, 0), N_SLOTS * last):
                yield time, number


def drift_table(title: str, drift: Drift) -> Table:
    """Log-likelihood of changed things' places by day since the change, and the share of the loss that is recovered.

    Args:
        title: of the table.
        drift: of the robots.
    """
    table = Table(title=title, title_justify="left")
    table.add_column("day", justify="right")
    for name in ROBOTS:
        table.add_column(f"{name}\nnats (made good)", justify="right")
    by_day = {name: drift.by_day(name) for name in ROBOTS}
    for day in by_day[TOLD]:
        cells = []
        for name in ROBOTS:
            good = f" ({100 * drift.made_good(name, day).mean:.0f} %)" if day > 0 else ""
            cells.append(f"{by_day[name][day].mean:.2f}{good}")
        table.add_row(str(day), *cells)
    return table
