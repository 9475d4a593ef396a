"""The thing that the end-to-end policy remembers near a place."""

from __future__ import annotations

import pytest
import torch

from models.nets.end_to_end.floor_memory import CHANNELS, HALF, SIZE
from models.nets.end_to_end.reasons import _NEAR, _name, _thing_near
from ucon.objects.catalogue import catalogue

MUG = catalogue().names.index("mug")


@pytest.mark.parametrize(
    ("away", "named"), [((0, 0), True), ((_NEAR, -_NEAR), True), ((-_NEAR, _NEAR), True), ((0, _NEAR + 1), False)]
)
def test_the_most_believed_thing_nearby_is_named(away: tuple[int, int], named: bool) -> None:
    cells = torch.zeros(1, len(CHANNELS), SIZE * SIZE, dtype=torch.uint8)
    what = torch.zeros(1, SIZE * SIZE, dtype=torch.int16)
    at = (HALF + 3 + away[0]) * SIZE + HALF - 5 + away[1]
    cells[0, -1, at], what[0, at] = 200, MUG
    other = (HALF + 4) * SIZE + HALF - 5
    cells[0, -1, other] += 100 if named else 0
    assert _thing_near({"cells": cells, "what": what}, 3, -5) == ("mug" if named else "")


def test_what_is_no_category_has_no_name() -> None:
    assert _name(MUG) == "mug"
    assert _name(-1) == _name(10**6) == "?"
