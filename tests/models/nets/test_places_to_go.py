"""Where the policy goes before it has learned anything: towards what is worth it, by the shortest way."""

from __future__ import annotations

import pytest
import torch

from models.nets.end_to_end.floor_memory import CHANNELS, WINDOW, Window, coarse
from models.nets.end_to_end.places_to_go import PlacesToGo, Ways

MIDDLE = WINDOW // 2


def weighed(channel: str, at: tuple[int, int], heading: int = 0, reach: int = 1) -> tuple[Ways, torch.Tensor]:
    """Its ways, and the blocks of two cells that hold something, ``reach`` cells around the one ``at`` so far away."""
    torch.manual_seed(0)
    places = PlacesToGo(3)
    with torch.no_grad():
        places.view[:, 1:] = 0.0  # what is drawn at random
    cells = torch.zeros(1, len(CHANNELS), WINDOW, WINDOW, dtype=torch.uint8)
    cells[:, CHANNELS.index("explored")] = cells[:, CHANNELS.index("floor")] = 255
    i, j = MIDDLE + at[0], MIDDLE + at[1]
    cells[0, CHANNELS.index(channel), i - reach : i + reach + 1, j - reach : j + reach + 1] = 255
    free = torch.ones(1, WINDOW, WINDOW, dtype=torch.bool)
    with torch.no_grad():
        found = places(Window(cells, free), torch.tensor([heading]), torch.zeros(1, 3))
    return found, coarse(cells)[0, CHANNELS.index(channel)]


def ways(channel: str, at: tuple[int, int], heading: int = 0) -> torch.Tensor:
    """Probability (4,) of ahead, right, left and staying."""
    return weighed(channel, at, heading)[0].log_p.exp()[0]


@pytest.mark.parametrize(
    ("at", "action"),
    [((12, 0), 0), ((0, 12), 2), ((0, -12), 1)],
    ids=["ahead", "left", "right"],
)
def test_it_goes_to_the_target(at: tuple[int, int], action: int) -> None:
    assert int(ways("target", at).argmax()) == action


def test_it_stops_half_a_metre_before_what_it_wants() -> None:
    """Poses are blocks of two cells: the best one is a block before the thing, and looks at it."""
    found, thing = weighed("target", (12, 0), reach=0)
    (block,) = (thing == thing.max()).nonzero().tolist()
    best = [int(k) for k in torch.unravel_index(found.goals[0].argmax(), found.goals[0].shape)]
    assert best == [0, block[0] - 1, block[1]]


def test_headings_are_alike() -> None:
    """The same thing on the same side is the same choice, whichever way the map is turned."""
    first = ways("closed", (12, 0), 0)
    for heading, at in ((1, (0, 12)), (2, (-12, 0)), (3, (0, -12))):
        assert ways("closed", at, heading) == pytest.approx(first, abs=0.02)
