"""Since when a thing has been kept as now: the posterior by hand, by enumeration, and in the place model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ucon.lives.clock import time_of
from ucon.memory.change_points import SPREAD, change_posterior
from ucon.memory.place_model import PlaceModel, PlaceWeights
from ucon.memory.sighting_log import SeenThing

DESK, SOFA, SHELF = range(3)
PLACES = np.array([[0.0, 0.0, 0.7], [3.0, 0.0, 0.4], [0.0, 3.0, 1.2]])
LEAST = 1e-3
EVEN = PlaceWeights(use=0.5, doubt=0.75, other_slot=1.0, other_days=1.0, change=0.01, news=0.7, mistakes=0.02)


def thing(*seen: tuple[int, int]) -> SeenThing:
    return SeenThing("book", PLACES, list(seen))


def counted_out(
    places: list[int], stays: np.ndarray, counts: np.ndarray, changes: np.ndarray, doubt: float, mistakes: float
) -> np.ndarray:
    """The posterior by enumeration of hypotheses and sightings; after a change, earlier sightings do not count."""
    n, scores = len(places), []
    for change in range(n + 1):
        p = 1.0 - sum(changes) if change == 0 else changes[change - 1]
        for k in range(n):
            since = change if k >= change else 0
            total = sum(counts[k, j] for j in range(since, k))
            hits = sum(counts[k, j] for j in range(since, k) if places[j] == places[k])
            put = (hits + doubt * SPREAD) / (total + doubt)
            put = (1.0 - mistakes) * put + mistakes * SPREAD
            stayed = stays[k] if k > 0 and places[k] == places[k - 1] else 0.0
            p *= max(stayed + (1.0 - stays[k]) * put, LEAST)
        scores.append(p)
    return np.array(scores) / sum(scores)


@pytest.mark.parametrize("seed", range(40))
def test_it_is_what_is_counted_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    places = rng.integers(0, 3, n)
    stays = rng.uniform(0.0, 1.0, n)
    stays[0] = 0.0
    counts = np.tril(rng.uniform(0.0, 1.0, (n, n)), -1)
    changes = rng.dirichlet(np.ones(n + 1))[:n]
    doubt, mistakes = float(rng.uniform(0.1, 3.0)), float(rng.uniform(0.0, 0.3))
    found = change_posterior(places, stays, counts, changes, doubt, mistakes)
    assert found == pytest.approx(counted_out(places.tolist(), stays, counts, changes, doubt, mistakes), rel=1e-9)
    assert found.sum() == pytest.approx(1.0)


def test_one_sighting_by_hand() -> None:
    """One sighting is equally probable under both hypotheses, so the prior stays."""
    one = change_posterior(np.array([0]), np.zeros(1), np.zeros((1, 1)), np.array([0.25]), 1.0, 0.0)
    assert one == pytest.approx([0.75, 0.25])


def test_two_sightings_by_hand() -> None:
    """The second is elsewhere: probability .05 if the first counts (0.1 of 2), .1 after a change."""
    counts = np.array([[0.0, 0.0], [1.0, 0.0]])
    two = change_posterior(np.array([0, 1]), np.zeros(2), counts, np.array([0.5, 0.0]), 1.0, 0.0)
    assert two == pytest.approx([1 / 3, 2 / 3, 0.0], abs=1e-9)
    # It is where the first was: probability 1.1 of 2, against .1.
    same = change_posterior(np.array([0, 0]), np.zeros(2), counts, np.array([0.5, 0.0]), 1.0, 0.0)
    assert same == pytest.approx([0.55 / 0.65, 0.1 / 0.65, 0.0], abs=1e-9)


def test_a_change_is_recognised_where_it_was() -> None:
    times = range(0, 60, 3)
    moved = thing(*((time, DESK if time < 30 else SOFA) for time in times))
    since = PlaceModel(EVEN).since(moved, 60)
    assert since.argmax() == 10
    assert since[10] > 0.8
    assert PlaceModel(EVEN).first(moved, 60) == 10
    still = thing(*((time, DESK) for time in times))
    assert PlaceModel(EVEN).first(still, 60) == 0
    assert PlaceModel(EVEN).since(still, 60)[0] > 0.8


def test_one_mistake_is_no_change() -> None:
    once = thing(*((time, SOFA if time == 30 else DESK) for time in range(0, 60, 3)))
    assert PlaceModel(EVEN).first(once, 60) == 0


def test_where_it_is_put_follows_the_change() -> None:
    moved = thing(*((time, DESK if time < 30 else SOFA) for time in range(0, 42, 3)))
    follows, never = (PlaceModel(replace(EVEN, change=change)) for change in (0.01, 0.0))
    slot = np.array([45])
    assert follows.put(moved, slot, 45)[0, SOFA] > never.put(moved, slot, 45)[0, SOFA] + 0.2
    assert never.since(moved, 45).tolist() == [1.0] + [0.0] * len(moved.seen)


def test_news_of_a_day_move_the_change_there() -> None:
    """A change is likelier on a day with new habits than on another day, or if no new habits were told."""
    seen = thing(*((time_of(day, 0), DESK if day < 5 else SOFA) for day in range(6)))
    model, now = PlaceModel(EVEN), time_of(6, 0)
    plain, then, before = (model.since(seen, now, told) for told in ((), (5,), (2,)))
    assert then[5] > plain[5] + 0.2
    assert then.argmax() == 5
    assert before[2] > plain[2]
    assert before[5] < then[5]


def test_news_after_the_last_sighting_leave_nothing_that_counts() -> None:
    seen, now = thing((0, DESK), (3, DESK), (6, DESK)), time_of(5, 0)
    model = PlaceModel(EVEN)
    told = model.since(seen, now, (4,))
    assert told[-1] > 0.5 > model.since(seen, now)[-1]
    assert model.now(seen, now, (4,))[DESK] < model.now(seen, now)[DESK]


def test_old_sentences_lose_what_new_ones_gain() -> None:
    """Once a thing is seen elsewhere after new sentences were told, the old ones no longer hold and the new ones do."""
    seen = thing(*((time_of(day, 0), DESK if day < 5 else SOFA) for day in range(9)))
    model, days = PlaceModel(EVEN), (0, 0, 5)
    for until, low, high in ((9, 0.0, 0.1), (6, 0.0, 0.5)):
        one = thing(*seen.seen[:until])
        old, other, new = model.valid(one, time_of(until, 0), (5,), days)
        assert old == other
        assert low <= old < high
        assert new > 0.8
    # Without news they hold, except for the change that the sightings show.
    before, after = (model.valid(thing(*seen.seen[:n]), time_of(n, 0), (), (0,))[0] for n in (5, 9))
    assert before > 0.7
    assert after < before - 0.1


def test_of_what_was_never_seen_news_alone_speak() -> None:
    model = PlaceModel(EVEN)
    assert model.valid(thing(), 30, (5,), (0, 5)) == pytest.approx([0.3, 1.0])
    assert model.valid(thing(), 30, (), (0, 0)).tolist() == [1.0, 1.0]
    assert model.valid(thing(), 30, (), ()).shape == (0,)


def test_news_before_a_thing_was_first_seen_count_as_if_it_was_never_seen() -> None:
    """Old sentences stay doubtful if the thing was first seen on the day of the news, or later."""
    model = PlaceModel(EVEN)
    for first in (5, 6):
        one = thing((time_of(first, 1), SOFA))
        old, new = model.valid(one, time_of(7, 0), (5,), (0, 5))
        assert old == pytest.approx(0.3, abs=0.02)
        assert new > 0.9
    assert model.valid(thing((time_of(4, 1), SOFA)), time_of(4, 2), (5,), (0,))[0] > 0.95, "of news to come"


def test_valid_is_a_probability() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        times = np.sort(rng.integers(0, 42, rng.integers(1, 12)))
        one = thing(*((int(t), int(rng.integers(3))) for t in times))
        told = tuple(sorted({int(day) for day in rng.integers(1, 14, rng.integers(3))}))
        days = tuple(int(day) for day in rng.integers(0, 14, 5))
        valid = PlaceModel().valid(one, 42, told, days)
        assert ((valid >= -1e-9) & (valid <= 1.0 + 1e-9)).all()
