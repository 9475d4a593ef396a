"""Where a thing is now, judging by its sightings: the place model, and the baselines."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.lives.clock import time_of
from ucon.memory.place_model import MISS, PlaceModel, PlaceWeights
from ucon.memory.sighting_log import SAME_M, SeenThing, SightingLog
from ucon.memory.simple_models import LastSeen, MostSeen

DESK, SOFA, SHELF = range(3)
PLACES = np.array([[0.0, 0.0, 0.7], [3.0, 0.0, 0.4], [0.0, 3.0, 1.2]])
MORNING, MIDDAY, EVENING = range(3)
#: A thing is used in half of all slots, and all sightings count the same.
PLAIN = PlaceWeights(use=0.5, doubt=1.0, other_slot=1.0, other_days=1.0, change=0.0)
#: Typical weights, independent of the fitted ones.
SOME = PlaceWeights(use=0.3, doubt=1.5, other_slot=0.6, other_days=0.7, change=0.0)


def thing(*seen: tuple[int, int], absent: tuple[tuple[int, int], ...] = ()) -> SeenThing:
    return SeenThing("book", PLACES, list(seen), list(absent))


def now(one: SeenThing, time: int, weights: PlaceWeights | None = SOME, first_weekday: int = 0) -> np.ndarray:
    model = PlaceModel(weights)
    model.begin(first_weekday)
    return model.now(one, time)


def put_at(model: PlaceModel, one: SeenThing, time: int) -> np.ndarray:
    return model.put(one, np.array([time]), time)[0]


def test_by_hand() -> None:
    """Seen at the desk one slot ago: it stays with 0.5, and otherwise is put there as often as elsewhere."""
    assert now(thing((0, DESK)), 1, PLAIN) == pytest.approx([0.5 + 0.5 * 0.5, 0.0, 0.0])
    # Used in either slot with 0.75; put there with (1 + 0.5) / 2.5, since no use may precede the second sighting.
    assert now(thing((0, DESK), (1, DESK)), 3, PLAIN)[DESK] == pytest.approx(0.25 + 0.75 * 1.5 / 2.5)


def test_what_was_never_seen_has_no_place() -> None:
    assert now(SeenThing("book"), 5).shape == (0,)
    assert (now(thing(), 5) == 0.0).all()


def test_probabilities_leave_something_for_elsewhere() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        times = np.sort(rng.choice(60, rng.integers(1, 12), replace=False))
        seen = tuple((int(t), int(rng.integers(3))) for t in times)
        absent = tuple((int(rng.integers(60)), int(rng.integers(3))) for _ in range(rng.integers(6)))
        time, first_weekday = int(times[-1] + rng.integers(90)), int(rng.integers(7))
        for weights in (None, SOME, PLAIN):
            p = now(thing(*seen, absent=absent), time, weights, first_weekday)
            assert (p >= 0.0).all()
            assert p.sum() <= 1.0 + 1e-12


def test_the_last_place_decays_with_time() -> None:
    one = thing((0, SOFA), (3, SOFA), (6, SOFA), (9, DESK))
    p = np.array([now(one, time) for time in (9, 12, 21, 30)])  # workday mornings
    assert p[0, DESK] == pytest.approx(1.0 - p[0, SOFA], abs=1e-6)
    assert (np.diff(p[:-1, DESK]) < 0.0).all()
    assert p[0].argmax() == DESK
    assert p[-1].argmax() == SOFA


def test_an_empty_look_removes_a_place_until_a_later_use() -> None:
    one, empty = thing((0, SOFA), (3, DESK)), thing((0, SOFA), (3, DESK), absent=((5, DESK),))
    assert now(one, 5)[DESK] > 0.3
    assert now(empty, 5)[DESK] == 0.0
    assert now(empty, 5)[SOFA] > now(one, 5)[SOFA]
    later = [now(empty, time)[DESK] for time in (5, 6, 8, 12)]
    assert later == sorted(later)
    assert 0.0 < later[-1] < 0.5


def test_an_empty_look_before_it_was_seen_there_says_nothing() -> None:
    assert now(thing((3, DESK), absent=((2, DESK), (3, SOFA))), 4)[DESK] == now(thing((3, DESK)), 4)[DESK]


def test_all_known_places_empty_is_elsewhere() -> None:
    assert now(thing((0, DESK), (2, SOFA), absent=((4, DESK), (4, SOFA))), 4).tolist() == [0.0, 0.0, 0.0]


def test_slots_of_the_day_shift_it() -> None:
    """A thing seen on the desk in mornings and on the sofa in evenings is expected there at those times."""
    seen = [(time_of(day, slot), place) for day in range(3) for slot, place in ((MORNING, DESK), (EVENING, SOFA))]
    model = PlaceModel(replace(SOME, other_slot=0.2))
    put = {slot: put_at(model, thing(*seen), time_of(3, slot)) for slot in (MORNING, MIDDAY, EVENING)}
    assert put[MORNING][DESK] > 2.0 * put[MORNING][SOFA]
    assert put[EVENING][SOFA] > 2.0 * put[EVENING][DESK]
    assert put[MIDDAY][DESK] == pytest.approx(put[MIDDAY][SOFA])
    assert all(p.sum() == pytest.approx(1.0) for p in put.values())


@pytest.mark.parametrize("first_weekday", [0, 3])
def test_weekends_shift_it(first_weekday: int) -> None:
    """A thing seen on the shelf at weekends and on the desk on workdays is expected there on those days."""
    weekend = {day for day in range(14) if (first_weekday + day) % 7 >= 5}
    seen = [(time_of(day, MORNING), SHELF if day in weekend else DESK) for day in range(7)]
    model = PlaceModel(replace(SOME, other_days=0.1))
    model.begin(first_weekday)
    for day in range(7, 14):
        put = put_at(model, thing(*seen), time_of(day, MORNING))
        assert (put[SHELF] > put[DESK]) == (day in weekend)


def test_a_place_seen_again_at_once_counts_less() -> None:
    again, later = (put_at(PlaceModel(PLAIN), thing((0, DESK), (gap, DESK)), gap)[DESK] for gap in (0, 20))
    assert again == pytest.approx(1.0 / 2.0)
    assert later == pytest.approx(2.0 / 3.0, abs=1e-4)


def test_after_long_only_what_is_usual_counts() -> None:
    one = thing((0, DESK), (1, SOFA))
    assert now(one, 1000, PLAIN) == pytest.approx([1 / 3, 1 / 3, 0.0])


def test_last_seen_trusts_until_it_is_wrong() -> None:
    model = LastSeen(trust=0.8)
    model.begin(0)
    one = thing((0, SOFA), (3, DESK), absent=((2, DESK), (3, SOFA)))
    assert model.now(one, 40).tolist() == [0.8, 0.0, 0.0]
    assert not model.now(thing((0, SOFA), (3, DESK), absent=((4, DESK),)), 5).any()
    assert not model.now(thing(), 5).any()


def test_most_seen_is_a_histogram() -> None:
    model = MostSeen(trust=0.8)
    model.begin(0)
    one = thing((0, SOFA), (3, DESK), (4, SOFA), (7, SOFA), absent=((8, SOFA),))
    assert model.now(one, 9) == pytest.approx([0.2, 0.6, 0.0])
    assert model.now(one, 99).tolist() == model.now(one, 9).tolist()
    assert not model.now(thing(), 5).any()


def test_sightings_near_one_another_are_of_one_place() -> None:
    log = SightingLog()
    for time, x in enumerate((0.0, 0.5 * SAME_M, 2.0, 2.0 + 0.9 * SAME_M, 0.0)):
        log.saw("book", np.array([x, 0.0, 0.5]), time)
    log.missed("book", 1, 5)
    one = log.things["book"]
    assert one.places[:, 0].tolist() == [0.0, 2.0]
    assert one.seen == [(0, 0), (1, 0), (2, 1), (3, 1), (4, 0)]
    assert one.absent == [(5, 1)]


@pytest.mark.parametrize("name", ["use", "other_slot", "other_days", "doubt", "change", "news", "mistakes"])
@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
def test_numbers_that_cannot_be_are_refused(name, value):
    with pytest.raises(ConfigError, match=f"{name}=.*expected") as raised:
        PlaceWeights(**{name: value})
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [("use", 1.1), ("other_slot", 1.1), ("other_days", 2), ("change", 1.1), ("news", 2), ("mistakes", 3), ("doubt", 0)],
)
def test_numbers_out_of_their_range_are_refused(name, value):
    with pytest.raises(ConfigError, match=f"{name}={value}, expected"):
        PlaceWeights(**{name: value})


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("name", "value"),
    [
        *product(("use", "other_slot", "other_days", "change", "news", "mistakes"), (0.0, 1e-9, 1.0)),
        *product(("doubt",), (1e-9, 1e9)),
    ],
)
def test_numbers_at_the_ends_of_their_range_give_probabilities(name, value):
    model = PlaceModel(replace(PlaceWeights(), **{name: value}))
    model.begin(0)
    one = thing((0, SOFA), (0, DESK), (4, DESK), (30, SHELF), absent=((31, SHELF), (31, DESK)))
    when = np.array([-1, 0, 29, 30, 31, 40])
    for told in ((), (9,), (12, 13)):
        for time in (31, 32, 40, 200):
            p = model.now(one, time, told)
            assert np.isfinite(p).all()
            assert p.sum() <= 1.0 + 1e-9
            assert model.since(one, time, told).sum() == pytest.approx(1.0)
            valid = model.valid(one, time, told, (0, 9))
            assert ((valid >= -1e-9) & (valid <= 1.0 + 1e-9)).all()
    for seen in (-1, 0, 30, 40):
        left = model.left(when[when <= 40], seen, 40)
        assert ((left >= MISS - 1e-9) & (left <= 1.0)).all()


def test_what_is_left_of_places_that_were_empty():
    """A place seen empty in this slot keeps only the chance of a miss; one seen empty two slots ago keeps more."""
    model = PlaceModel(PLAIN)
    never, before, two_ago, now_ = model.left(np.array([-1, 2, 8, 10]), 4, 10)
    assert never == before == 1.0
    assert now_ == pytest.approx(MISS)
    # Probability of use: 1 - 2^-6 since it was seen, 1 - 2^-2 since the look.
    assert two_ago == pytest.approx(MISS + (1 - MISS) * 0.75 / (1 - 2.0**-6))
    # For a thing never seen, only use since the look counts.
    assert model.left(np.array([8, 10]), -1, 10) == pytest.approx([MISS + (1 - MISS) * 0.75, MISS])
    # If it was seen in this slot, earlier looks at other places say nothing.
    assert model.left(np.array([8, 10]), 10, 10).tolist() == [1.0, 1.0]
    assert LastSeen().left(np.array([8, 10]), -1, 10).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("model", [LastSeen, MostSeen])
def test_a_trust_is_a_probability(model):
    with pytest.raises(ConfigError, match=r"trust=1\.5, expected 0 to 1"):
        model(trust=1.5)
