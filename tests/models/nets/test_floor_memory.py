"""What one step writes into the map, by hand: an agent in the middle that looks along the first axis."""

from __future__ import annotations

import pytest
import torch

from models.nets.end_to_end.ego_kernels import SEEN_FLOOR
from models.nets.end_to_end.ego_view import ASIDE, BEHIND, COLUMNS, ROWS
from models.nets.end_to_end.floor_memory import CHANNELS, HALF, SIZE, FloorMemory, MemoryStep, State

FRONT = (3 + BEHIND) * COLUMNS + ASIDE
"""The cell of the patch three ahead."""


def step(*pairs: tuple[int, float, int], heading: int = 0, collision: bool = False) -> MemoryStep:
    """``pairs``: cell of the patch, belief that the target is on top of what is there, number of its category."""
    mass = torch.zeros(1, 6, max(len(pairs), 1))
    for k, (_, belief, _) in enumerate(pairs):
        mass[0, 0, k] = belief
    patch = torch.zeros(1, ROWS, COLUMNS, dtype=torch.uint8)
    patch.view(-1)[FRONT] = SEEN_FLOOR
    return MemoryStep(
        pose=torch.tensor([[0, 0, heading, 0]]),
        collision=torch.tensor([collision]),
        patch=patch,
        look=torch.zeros(1, ROWS, COLUMNS, dtype=torch.uint8),
        pair_cell=torch.tensor([[cell for cell, _, _ in pairs] or [-1]]),
        pair_mass=mass,
        pair_category=torch.tensor([[name for _, _, name in pairs] or [0]]),
    )


def written(*steps: MemoryStep) -> tuple[dict[str, torch.Tensor], torch.Tensor]:
    memory = FloorMemory()
    state: State = memory.initial_state(1, torch.device("cpu"))
    for one in steps:
        memory.write(state, one)
    cells = state["cells"].view(len(CHANNELS), SIZE, SIZE)
    return dict(zip(CHANNELS, cells, strict=True)), state["what"].view(SIZE, SIZE)


@pytest.mark.parametrize(("heading", "at"), [(0, (3, 0)), (1, (0, 3)), (2, (-3, 0)), (3, (0, -3))])
def test_what_lies_ahead_is_written_where_it_looks(heading: int, at: tuple[int, int]) -> None:
    cells, _ = written(step(heading=heading))
    assert cells["floor"].nonzero().tolist() == [[HALF + at[0], HALF + at[1]]]


def test_where_it_stands_is_explored_and_counted() -> None:
    cells, _ = written(step(), step())
    assert cells["visited"].nonzero().tolist() == cells["explored"].nonzero().tolist() == [[HALF, HALF]]
    assert int(cells["visited"][HALF, HALF]) == 128
    often, _ = written(*[step()] * 5)
    assert int(often["visited"][HALF, HALF]) == 255, "as much as there is room for"


def test_a_bump_blocks_the_cell_ahead() -> None:
    assert written(step(collision=True))[0]["blocked"].nonzero().tolist() == [[HALF + 1, HALF]]
    assert not written(step())[0]["blocked"].any()


def test_a_cell_is_called_by_what_speaks_most_for_the_target() -> None:
    """Belief is kept as its root; a thing without any names nothing, and a weaker one later changes no name."""
    there = (HALF + 3, HALF)
    cells, what = written(step((FRONT, 0.25, 7), (FRONT, 0.04, 9)))
    assert int(cells["ontop"][there]) == int(cells["most"][there]) == 127
    assert int(what[there]) == 7
    assert int((what >= 0).sum()) == 1
    cells, what = written(step((FRONT, 0.04, 9)), step((FRONT, 0.25, 7)), step((FRONT, 0.16, 5)))
    assert (int(what[there]), int(cells["most"][there])) == (7, 127)
    _, nothing = written(step((FRONT, 0.0, 7)))
    assert not (nothing >= 0).any()
    _, none = written(step((-1, 1.0, 7)))
    assert not (none >= 0).any(), "a pair that is none"
