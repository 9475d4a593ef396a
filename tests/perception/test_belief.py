"""How belief is divided among seen things, unexplored space and the flat tail: by hand, in a home with two sofas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.target_belief import KNOWN_HOME, BeliefWeights, Locations, TargetBelief
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View
from ucon.perception.places.neighbourhood import interest
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

#: All different from each other and from the defaults, so that mix-ups are noticed.
WEIGHTS = BeliefWeights(tail=0.2, hidden=0.5, exists=0.25, home_m2=100.0, least_m2=10.0, least_share=0.25)
#: On a sofa .6; in a fridge .2; the rest is anywhere.
LOCATIONS = Locations(("sofa", "fridge"), np.array([[0.6, 0, 0, 0], [0, 0.2, 0, 0]]))
#: The belief of a whole home in the units of coverage.
UNITS = 450.0
PLACES = Places(0.1)


def wanting(known: SemanticMap, wanted: dict[str, float]) -> np.ndarray:
    """Factors of the worth of unexplored cells if so much of each category is expected there."""
    return interest(known, tuple(wanted), np.array(list(wanted.values())))


def coverage() -> Coverage:
    return Coverage("mug", CoverageWeights())


def home(floor_m2: float, sofas: int = 2) -> SemanticMap:
    """A map with so much floor seen (16 cells per square metre) and so many sofas on it."""
    known = SemanticMap()
    known.views.append(View(HALF, HALF, 0))
    for number in range(round(16 * floor_m2)):
        known.floor[HALF + number // 100, HALF + number % 100] = 1
    known.explored[:] = known.floor
    for track in range(sofas):
        known.category.append("sofa")
        known.instances.setdefault("sofa", []).append(track)
        known.box[track] = (1.0, 3.0 * track, 0.0, 2.0, 3.0 * track + 2.0, 0.8)
        known.last_seen[track] = 0
    return known


def expected(floor_m2: float, weights: BeliefWeights = WEIGHTS, locations: Locations = LOCATIONS) -> Expectation:
    return TargetBelief(locations, coverage(), weights).expect(home(floor_m2), PLACES)


def without_tail(**changes: float) -> BeliefWeights:
    """Weights without the part of belief that follows coverage, so that only the habits count."""
    return replace(WEIGHTS, tail=0.0, **changes)


SURE = Locations(LOCATIONS.names, LOCATIONS.p / 0.8)


def test_a_share_goes_to_what_was_seen_and_the_rest_waits_unexplored() -> None:
    """60 of 100 m2 are seen, so .4 of the home is left: the sofas keep .6 x (1 - .5 x .4) = .48, and .4 x (.5 x .6
    + .25 x .2) = .14 is spread over 40 m2; both are scaled to the .8 that the habits account for."""
    found = expected(60.0)
    scale = 0.8 / (0.48 + 0.14)
    tail = (0.2 + 0.8 * 0.2) / UNITS
    flat = coverage().expect(home(60.0), PLACES)
    by_habits = found.mass - tail * flat.mass
    assert by_habits[:, 0] == pytest.approx([0.8 * scale * 0.24] * 2), "both sofas alike"
    assert by_habits[:, 1:] == pytest.approx(0.0)
    assert found.unknown_per_m2 == pytest.approx(0.8 * scale * 0.14 / 40.0 + tail * flat.unknown_per_m2)
    assert found.near_per_m2 == pytest.approx(tail * flat.near_per_m2)


@pytest.mark.parametrize(
    ("floor_m2", "left_m2"),
    [(60.0, 40.0), (78.0, 22.0), (84.0, 21.0), (200.0, 50.0)],
    ids=["what is left of the home", "still", "a quarter of what was seen", "in a home larger than expected"],
)
def test_the_unexplored_rest_is_never_nothing(floor_m2: float, left_m2: float) -> None:
    """Habits account for everything here, so what is not at the sofas is spread over the rest of the home."""
    found = expected(floor_m2, without_tail(), SURE)
    assert found.mass.sum() + found.unknown_per_m2 * left_m2 == pytest.approx(1.0)


def test_a_least_floor_is_left_in_a_small_home() -> None:
    found = expected(30.0, without_tail(home_m2=32.0), SURE)
    assert found.mass.sum() + found.unknown_per_m2 * 10.0 == pytest.approx(1.0)


def test_in_a_known_home_nothing_waits() -> None:
    found = expected(60.0, replace(KNOWN_HOME, tail=0.0), SURE)
    assert found.unknown_per_m2 == pytest.approx(0.0)
    assert found.mass[:, 0] == pytest.approx([0.5, 0.5])


def test_what_habits_leave_open_follows_coverage() -> None:
    """If habits say nothing about places, or are not believed at all, the result is coverage in other units."""
    flat = coverage().expect(home(60.0), PLACES)
    silent = Locations(("sofa",), np.zeros((1, 4)))
    for found in (expected(60.0, WEIGHTS, silent), expected(60.0, replace(WEIGHTS, tail=1.0))):
        assert found.mass == pytest.approx(flat.mass / UNITS)
        assert found.unknown_per_m2 == pytest.approx(flat.unknown_per_m2 / UNITS)
        assert found.near_per_m2 == pytest.approx(flat.near_per_m2 / UNITS)
        assert found.interest == pytest.approx(np.ones_like(found.interest))


def test_more_than_certain_leaves_nothing_open() -> None:
    """Sums of rounded probabilities may exceed 1; this must not take mass away from coverage."""
    over = Locations(("sofa",), np.array([[1.25, 0, 0, 0]]))
    found = expected(60.0, WEIGHTS, over)
    assert found.near_per_m2 == pytest.approx(0.2 / UNITS * CoverageWeights().near)


def test_neighbourhoods_count_as_far_as_habits_speak_of_the_unexplored() -> None:
    """Expected there: .5 x .6 at sofas (some were seen) and .25 x .2 at fridges (none was seen)."""
    known = home(60.0)
    found = TargetBelief(LOCATIONS, coverage(), WEIGHTS).expect(known, PLACES)
    assert found.interest is not None
    factors = wanting(known, {"sofa": 0.3, "fridge": 0.05})
    tail = (0.2 + 0.8 * 0.2) / UNITS * CoverageWeights().unknown
    part = 1.0 - tail / found.unknown_per_m2
    assert 0.1 < part < 0.9
    assert factors.std() > 0.01
    assert found.interest == pytest.approx(1.0 - part + part * factors, abs=1e-5)


def test_it_follows_what_is_seen() -> None:
    """A new sofa shares the sofas' mass; more explored floor leaves less to be found elsewhere."""
    believing = TargetBelief(SURE, coverage(), without_tail())
    known = home(60.0)
    before = believing.expect(known, PLACES)
    known.floor[0, :16] = 1
    grown = believing.expect(known, PLACES)
    assert grown.mass.sum() > before.mass.sum()
    third = home(61.0, sofas=3)
    after = believing.expect(third, PLACES)
    assert after.mass[:, 0] == pytest.approx([grown.mass.sum() / 3] * 3)


def test_new_locations_replace_the_old() -> None:
    believing, known = TargetBelief(SURE, coverage(), without_tail()), home(60.0)
    believing.expect(known, PLACES)
    elsewhere = Locations(("sofa", "fridge"), np.array([[0.0, 0, 0, 0], [0, 1.0, 0, 0]]))
    believing.believe(elsewhere)
    found = believing.expect(known, PLACES)
    assert found.mass == pytest.approx(0.0)
    assert found.unknown_per_m2 == pytest.approx(1.0 / 40.0)
    assert believing.locations is elsewhere
