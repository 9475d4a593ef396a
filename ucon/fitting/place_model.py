"""Fits the place model on played lives: the robots' kept sightings against where things really were.

    python -m ucon lives make lives_train --limit 48 --out train.lives.xz
    python eval.py task=resident episodes=train.lives.xz agent=belief memory=sightings memory.keep=kept
    python -m ucon data fit-memory train.lives.xz kept

For every request for a thing that was seen before, the model predicts its place from what was seen up to the slot
before. The fit maximises the likelihood of the true places, trying the values of one parameter after the other until
nothing changes. The fitted values are printed; :class:`ucon.memory.place_model.PlaceWeights` holds those in use.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from ucon.core.errors import DataError
from ucon.core.progress import Progress
from ucon.evaluation.kept_memories import ELSEWHERE_P, NEAR_M, Truth, until
from ucon.lives.clock import N_SLOTS
from ucon.lives.life import Life
from ucon.lives.sets import load_lives
from ucon.lives.timeline import Timeline
from ucon.memory.log_file import load_log, log_name
from ucon.memory.place_model import Model, PlaceModel, PlaceWeights
from ucon.memory.sighting_log import SeenThing, SightingLog
from ucon.memory.simple_models import LastSeen, MostSeen

#: Values that are tried, by parameter.
GRID: Final[dict[str, Sequence[float]]] = {
    "use": (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4),
    "doubt": (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0),
    "other_slot": (0.2, 0.4, 0.6, 0.8, 1.0),
    "other_days": (0.2, 0.4, 0.55, 0.7, 0.85, 1.0),
    "change": (0.0, 0.001, 0.003, 0.01, 0.03),
    "mistakes": (0.02, 0.05, 0.1, 0.2),
}
_LEAST = 1e-3
_SLACK = 1e-5


@dataclass(frozen=True, eq=False)
class Case:
    """One request for a thing that was seen before.

    Attributes:
        thing: what was known of it.
        time: of the request.
        place: number of the known place where it is; None where it is elsewhere.
        first_weekday: of the life.
        news: days on which new habits of it were told.
    """

    thing: SeenThing
    time: int
    place: int | None
    first_weekday: int
    news: tuple[int, ...]


def cases_of(life: Life, log: SightingLog) -> Iterable[Case]:
    """The cases of one life.

    Args:
        life: the life.
        log: what the robot had seen at its end.
    """
    truth, timeline = Truth.of(life), Timeline(life)
    for asked in life.requests:
        one, at = life.possessions[asked.possession], int(timeline.at[asked.time, asked.possession])
        thing = until(log.things.get(one.category, SeenThing(one.category)), asked.time)
        if thing.seen:
            away = np.linalg.norm(thing.places - truth.xyz[asked.possession][at], axis=1)
            place = int(away.argmin()) if away.min() <= NEAR_M else None
            told = life.change_day if one.later else None
            news = () if told is None or told > asked.time // N_SLOTS else (told,)
            yield Case(thing, asked.time, place, life.first_weekday, news)


def likelihood(model: Model, cases: Sequence[Case]) -> tuple[float, float]:
    """Mean log-likelihood of the true places in nats, and how often the most likely place is the true one.

    Args:
        model: says where things are.
        cases: requests.
    """
    total, right = 0.0, 0
    for case in cases:
        model.begin(case.first_weekday)
        p = model.now(case.thing, case.time, case.news)
        here = (1.0 - float(p.sum())) * ELSEWHERE_P if case.place is None else float(p[case.place])
        total += float(np.log(max(here, _LEAST)))
        right += case.place is not None and int(p.argmax()) == case.place
    return total / len(cases), right / len(cases)


def fitted(cases: Sequence[Case], weights: PlaceWeights | None = None) -> PlaceWeights:
    """The parameters that maximise the likelihood of the true places.

    Args:
        cases: requests.
        weights: to start from; those in use by default.
    """
    best = weights or PlaceWeights()
    value, changed = likelihood(PlaceModel(best), cases)[0], True
    while changed:
        changed = False
        for name, values in GRID.items():
            for tried in values:
                other = replace(best, **{name: tried})
                if (new := likelihood(PlaceModel(other), cases)[0]) > value + _SLACK:
                    best, value, changed = other, new, True
    return best


def main(words: Sequence[str]) -> None:
    """Fit and print.

    Args:
        words: a set of lives and a folder of kept memories.

    Raises:
        DataError: no life of the set has a memory there, or no request is for a thing that was seen before.
    """
    parser = argparse.ArgumentParser(prog="python -m ucon data fit-memory", description="fit the place model")
    parser.add_argument("lives", help="set of lives or file")
    parser.add_argument("kept", type=Path, help="folder that memory.keep= wrote")
    args = parser.parse_args(words)
    lives = [life for life in load_lives(args.lives) if (args.kept / log_name(life.id)).is_file()]
    if not lives:
        raise DataError(f"{args.kept}: no memory of a life of {args.lives}; play them with memory.keep={args.kept}")
    cases: list[Case] = []
    with Progress("reading memories", len(lives), unit="lives") as bar:
        for number, life in enumerate(lives, 1):
            cases += cases_of(life, load_log(args.kept / log_name(life.id), life.id))
            bar.update(number)
    if not cases:
        raise DataError(f"{args.kept}: no request for a thing that was seen before; play longer lives")
    for name, model in (("last seen", LastSeen()), ("most seen", MostSeen()), ("in use", PlaceModel())):
        nats, right = likelihood(model, cases)
        sys.stdout.write(f"{name:<10} {nats:.4f} nats  first guess {right:.3f}\n")
    best = fitted(cases)
    nats, right = likelihood(PlaceModel(best), cases)
    sys.stdout.write(f"{'fitted':<10} {nats:.4f} nats  first guess {right:.3f}  ({len(cases)} requests)\n{best}\n")
