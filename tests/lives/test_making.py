"""Making lives: equal for equal seeds, consistent places, and people who follow their habits except for mistakes."""

from dataclasses import replace
from itertools import combinations

import pytest

from ucon.habits.book import contexts_book
from ucon.lives.making.make_life import make_life
from ucon.lives.making.make_sets import make_lives
from ucon.lives.making.plans import LIFE_SETS, life_orders, train_order
from ucon.lives.meeting import meet, object_boxes
from ucon.lives.verify import verify_life


@pytest.fixture(scope="module")
def order():
    return replace(train_order(2, contexts_book(), days=3), changes=False)


@pytest.fixture(scope="module")
def made(order):
    return make_life(order, contexts_book())


@pytest.mark.slow
def test_a_life_is_the_same_for_a_seed_and_another_for_another(order, made):
    assert make_life(order, contexts_book()).hash == made.hash
    assert make_life(replace(order, seed=order.seed + 1), contexts_book()).hash != made.hash


def test_a_life_verifies(made):
    assert verify_life(made, contexts_book()) == []
    assert len(made.requests) == 4 * made.days


def test_no_two_places_touch(made):
    boxes = [object_boxes(place.object) for one in made.possessions for place in one.places]
    assert len(boxes) >= 2 * len(made.possessions)
    assert not any(meet(a, b) for a, b in combinations(boxes, 2))


@pytest.mark.slow
def test_an_interrupted_set_goes_on(order, made, tmp_path):
    journal = tmp_path / "x.part"
    orders = [order, replace(order, id="other", seed=order.seed + 1)]
    first = make_lives(orders[:1], workers=1, journal=journal)
    assert [life.hash for life in first] == [made.hash]
    with journal.open("a") as notes:
        notes.write('{"half a line')
    counts = []
    both = make_lives(orders, workers=1, journal=journal, progress=counts.append)
    assert counts == [1, 2]
    assert both[0].hash == made.hash
    assert [life.hash for life in make_lives(orders, workers=1, journal=journal)] == [life.hash for life in both]


@pytest.mark.slow
def test_lives_do_not_depend_on_the_number_of_workers(order, made):
    orders = [order, replace(order, id="other", seed=order.seed + 1)]
    assert [x.hash for x in make_lives(orders, workers=2)] == [x.hash for x in make_lives(orders, workers=1)]


@pytest.mark.parametrize("name", LIFE_SETS)
def test_plans_are_as_the_design_says(name):
    orders = list(life_orders(name, contexts_book()))
    assert len(orders) == {"lives_mini": 4, "lives_val": 20, "lives_test": 40, "lives_long": 4}[name]
    assert len({order.seed for order in orders}) == len(orders)
    assert sum(order.changes for order in orders) * 2 == len(orders)
    assert {order.days for order in orders} == {50 if name == "lives_long" else 14}
