"""How a robot names the place of a thing: on the tray, not on the table below it; in the fridge; under the bed."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.memory.naming import spot_of
from ucon.perception.errors.model import read_errors
from ucon.perception.mapping.semantic_map import SemanticMap

Box = tuple[float, float, float, float, float, float]
TABLE: Box = (2.0, 2.0, 0.0, 3.2, 2.8, 0.75)
TRAY: Box = (2.2, 2.2, 0.75, 2.5, 2.5, 0.774)
FRIDGE: Box = (5.0, 0.0, 0.0, 5.7, 0.7, 1.8)
BED: Box = (0.0, 5.0, 0.0, 2.0, 6.5, 0.6)
LAMP: Box = (2.95, 2.4, 0.75, 3.1, 2.55, 1.11)
ROOM = {"breakfast_table": TABLE, "tray": TRAY, "fridge": FRIDGE, "bed": BED, "table_lamp": LAMP}


def mapped(**boxes: Box) -> SemanticMap:
    known = SemanticMap(target="")
    known.category.extend(boxes)
    known.box[: len(boxes)] = np.array(list(boxes.values())).reshape(-1, 6)
    return known


def at(x: float, y: float, z: float, size: tuple[float, float, float] = (0.08, 0.08, 0.07)) -> np.ndarray:
    """The box of a thing that stands at a point."""
    dx, dy, dz = size
    return np.array([x - dx / 2, y - dy / 2, z, x + dx / 2, y + dy / 2, z + dz])


def test_a_cup_on_a_tray_on_a_table_is_on_the_tray() -> None:
    held = spot_of(mapped(**ROOM), "coffee_cup", at(2.35, 2.35, 0.774))[0]
    assert held == ("ontop", "tray")


def test_a_cup_beside_the_tray_is_on_the_table() -> None:
    holds, near = spot_of(mapped(**ROOM), "coffee_cup", at(2.65, 2.35, 0.75))
    assert holds == ("ontop", "breakfast_table")
    assert near[0] == "nextto"


def test_a_thing_in_the_fridge() -> None:
    assert spot_of(mapped(**ROOM), "butter", at(5.3, 0.35, 0.9))[0] == ("inside", "fridge")
    assert spot_of(mapped(**ROOM), "butter", at(5.3, 0.35, 1.8))[0] == ("ontop", "fridge")


def test_a_shoe_under_the_bed_and_one_on_it() -> None:
    known = mapped(**ROOM)
    assert spot_of(known, "sandal", at(1.0, 5.4, 0.0, (0.25, 0.1, 0.08)))[0] == ("under", "bed")
    assert spot_of(known, "sandal", at(1.0, 5.4, 0.6, (0.25, 0.1, 0.08)))[0] == ("ontop", "bed")
    assert spot_of(known, "sandal", at(2.2, 5.4, 0.0, (0.25, 0.1, 0.08))) == (("nextto", "bed"),)


def test_a_book_beside_the_lamp_on_the_table() -> None:
    spot = spot_of(mapped(**ROOM), "hardback", at(2.75, 2.45, 0.75, (0.2, 0.15, 0.03)))
    assert spot[0] == ("ontop", "breakfast_table")
    assert spot[1][0] == "nextto"
    near_lamp = spot_of(mapped(breakfast_table=TABLE, table_lamp=LAMP), "hardback", at(2.75, 2.45, 0.75))
    assert near_lamp == (("ontop", "breakfast_table"), ("nextto", "table_lamp"))


def test_far_from_all_there_is_no_name() -> None:
    assert spot_of(mapped(**ROOM), "coffee_cup", at(8.0, 8.0, 0.0)) == ()
    assert spot_of(mapped(), "coffee_cup", at(8.0, 8.0, 0.0)) == ()


@pytest.mark.parametrize("lost", ["stale", "kind", "box", "category"])
def test_what_the_map_does_not_hold_names_nothing(lost: str) -> None:
    """A table that was moved away, a wall, a thing without a box, and the thing itself."""
    known = mapped(breakfast_table=TABLE)
    cup = at(2.65, 2.35, 0.75)
    assert spot_of(known, "coffee_cup", cup) == (("ontop", "breakfast_table"),)
    if lost == "stale":
        known.stale[0] = True
    elif lost == "kind":
        known.kind[0] = 1
    elif lost == "box":
        known.box[0] = (1e3, 1e3, 1e3, -1e3, -1e3, -1e3)
    else:
        known.category[0] = "coffee_cup"
    assert spot_of(known, "coffee_cup", cup) == ()


def test_boxes_of_a_detector_that_errs_may_be_off() -> None:
    """A cup 0.12 m below a table's top counts as on it; one 0.12 m above does only if boxes are inexact."""
    known, cup = mapped(breakfast_table=TABLE), at(2.65, 2.35, 0.63)
    assert spot_of(known, "coffee_cup", cup)[0] == ("ontop", "breakfast_table")
    cup = at(2.65, 2.35, 0.87)
    assert spot_of(known, "coffee_cup", cup) == ()
    known.inexact = True
    assert spot_of(known, "coffee_cup", cup)[0] == ("ontop", "breakfast_table")


def test_what_was_found_from_one_side_alone_counts_less() -> None:
    """Two tables at the same place, one of them found from six sides."""
    known = SemanticMap(errors=read_errors("noisy"), target="")
    known.inexact = True
    known.category.extend(["breakfast_table", "coffee_table"])
    known.box[:2] = [TABLE, TABLE]
    assert known.hypotheses is not None
    known.hypotheses.support(2)
    names = {}
    for often in ([6, 1], [1, 6]):
        known.hypotheses._found[:2] = often
        names[often[0]] = spot_of(known, "coffee_cup", at(2.65, 2.35, 0.75))[0][1]
    assert names == {6: "breakfast_table", 1: "coffee_table"}
