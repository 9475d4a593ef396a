"""Only orders whose home can hold one of their targets are kept."""

from __future__ import annotations

from ucon.habits import book
from ucon.task.making.make_sets import hosted_orders
from ucon.task.making.set_plans import Order

ORDERS = [
    Order("a", "Rs_int", 0, "these", ("mug", "not_there"), None),
    Order("b", "Rs_int", 1, "those", ("not_there",), None),
    Order("c", "office_large", 2, "these", None, None),
    Order("d", "Rs_int", 3, "those", ("not_there",), None),
    Order("e", "Rs_int", 4, "these", ("mug",), None),
]


def test_groups_of_one_home_are_judged_each_by_its_targets() -> None:
    said: list[str] = []
    found = hosted_orders(ORDERS, book(), workers=1, left_out=said.append)
    assert [order.id for order in found] == ["a", "c", "e"]
    assert said == ["Rs_int, those: left out, no target of dataset 'book' can be placed there"]
    first = hosted_orders(ORDERS, book(), limit=1, workers=1, left_out=said.append)
    assert [order.id for order in first] == ["a"]
    assert len(said) == 1
