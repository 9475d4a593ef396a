"""The thing that the end-to-end policy remembers near a place."""

from __future__ import annotations

import pytest
import torch

from models.nets.end_to_end.floor_memory import HALF, N_TRACKS, initial_maps
from models.nets.end_to_end.reasons import _NEAR, _name, _thing_near
from ucon.objects.catalogue import catalogue

MUG = catalogue().names.index("mug")


@pytest.mark.parametrize(
    ("away", "named"), [((0, 0), True), ((_NEAR, -_NEAR), True), ((-_NEAR, _NEAR), True), ((0, _NEAR + 1), False)]
)
def test_the_most_believed_thing_nearby_is_named(away: tuple[int, int], named: bool) -> None:
    state, believed = initial_maps(1, torch.device("cpu")), torch.zeros(1, N_TRACKS, 4)
    state["who"][0, 1, HALF + 3 + away[0], HALF - 5 + away[1]] = 7
    state["kind"][0, 7], believed[0, 7, 2] = MUG, 0.2
    if named:
        state["who"][0, 0, HALF + 4, HALF - 5] = 8
        state["kind"][0, 8], believed[0, 8, 0] = MUG + 1, 0.1
    assert _thing_near(state, believed, 3, -5) == ("mug" if named else "")


def test_what_is_no_category_has_no_name() -> None:
    assert _name(MUG) == "mug"
    assert _name(-1) == _name(10**6) == "?"
