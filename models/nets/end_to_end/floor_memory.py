"""The map memory: a grid of where the agent has been and what it saw there, kept in the recurrent state.

0.25 m cells around the start, written by fixed rules from each frame's :mod:`models.nets.end_to_end.ego_view`: no
parameters, no gradient, a pure function of the sequence of frames. The network reads a window around the agent.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED, SEEN_FLOOR
from models.nets.end_to_end.ego_view import ASIDE, BEHIND, COLUMNS, N_CELLS, ROWS

HALF = 128
SIZE = 2 * HALF + 1
"""Cells of a side of the map: 64 m, with the start in the middle."""
REACH = 40
WINDOW = 2 * REACH + 1
"""Cells of a side of the window: 10 m to each side of the agent."""
CHANNELS = (
    *("explored", "floor", "blocked", "looked", "ontop", "beside", "inside", "closed"),
    *("opened", "target", "visited", "most"),
)
"""Layers of the map, uint8.

``ontop`` to ``closed`` hold the belief that the target is with a thing in the cell, relative to the best category: on
it, beside or under it, in an open one, in a closed one (stored as 255 times the square root). ``most`` is the largest
of these; ``visited`` counts visits in steps of 64.
"""
_MASSES = slice(4, 10)
_MOST = CHANNELS.index("most")
N_TRACKS = 512

State = dict[str, Tensor]


class MemoryStep(NamedTuple):
    """What one step writes, for B episodes."""

    pose: Tensor
    """(B, 4) int: cell (i, j) relative to the start, heading in quarter turns, look up or down."""
    collision: Tensor
    """(B,) bool, the last move hit something."""
    patch: Tensor
    """(B, ROWS, COLUMNS) uint8, bits of :mod:`models.nets.end_to_end.ego_view`."""
    look: Tensor
    """(B, ROWS, COLUMNS) uint8, how closely each cell was seen."""
    pair_cell: Tensor
    """(B, P) int, cell of the patch of each (thing, cell) pair; -1 for none."""
    pair_mass: Tensor
    """(B, 6, P) in [0, 1]: ontop, beside, inside, closed, opened, target."""
    pair_category: Tensor
    """(B, P) int, category of the thing."""


class Window(NamedTuple):
    """The part of the map around an agent."""

    cells: Tensor
    """(B, len(CHANNELS), WINDOW, WINDOW) uint8 along the map's axes, with the agent in the middle."""
    free: Tensor
    """(B, WINDOW, WINDOW) bool, False where cells are known to be impassable."""


class FloorMemory(torch.nn.Module):
    """Writes frames into maps and reads windows from them."""

    offsets: Tensor

    def __init__(self) -> None:
        super().__init__()
        f = torch.arange(N_CELLS) // COLUMNS - BEHIND
        left = torch.arange(N_CELLS) % COLUMNS - ASIDE
        turns = ((1, 0), (0, 1), (-1, 0), (0, -1))
        offsets = torch.stack([torch.stack([c * f - s * left, s * f + c * left]) for c, s in turns])
        self.register_buffer("offsets", offsets, persistent=False)  # (4, 2, N_CELLS): cells of the patch by heading

    def initial_state(self, batch: int, device: torch.device) -> State:
        """Empty maps: ``cells`` (B, channels, SIZE ** 2) uint8 of 0, ``what`` (B, SIZE ** 2) int16 of -1."""
        cells = torch.zeros(batch, len(CHANNELS), SIZE * SIZE, dtype=torch.uint8, device=device)
        what = torch.full((batch, SIZE * SIZE), -1, dtype=torch.int16, device=device)
        return {"cells": cells, "what": what}

    @torch.no_grad()
    def write(self, state: State, step: MemoryStep) -> None:
        """Write one step into the maps, in place.

        Args:
            state: maps as of :meth:`initial_state`.
            step: what was seen.
        """
        cells, what = state["cells"], state["what"]
        here = step.pose[:, :2].long() + HALF
        at = here[:, :, None] + self.offsets[step.pose[:, 2].long()]  # (B, 2, N_CELLS)
        inside = ((at >= 0) & (at < SIZE)).all(1)
        index = at.clamp(0, SIZE - 1)
        flat = index[:, 0] * SIZE + index[:, 1]  # (B, N_CELLS)
        flags = step.patch.flatten(1)
        seen = torch.stack([(flags & bit).bool() * 255 for bit in (EXPLORED, SEEN_FLOOR, BLOCKED)], 1).to(torch.uint8)
        new = torch.cat([seen, step.look.flatten(1)[:, None]], 1) * inside[:, None]
        cells[:, :4].scatter_reduce_(2, flat[:, None].expand(-1, 4, -1), new, "amax")
        self._write_pairs(cells, what, flat, inside, step)
        self._write_self(cells, here, step)

    def _write_pairs(self, cells: Tensor, what: Tensor, flat: Tensor, inside: Tensor, step: MemoryStep) -> None:
        """Write the belief of things into their cells; ``what`` keeps the category of the highest belief."""
        there = (step.pair_cell >= 0) & inside.gather(1, step.pair_cell.clamp(min=0).long())
        target = flat.gather(1, step.pair_cell.clamp(min=0).long())  # (B, P)
        mass = (255 * step.pair_mass.clamp(0, 1).sqrt() * there[:, None]).to(torch.uint8)
        cells[:, _MASSES].scatter_reduce_(2, target[:, None].expand(-1, mass.shape[1], -1), mass, "amax")
        most = mass[:, :4].amax(1)
        cells[:, _MOST].scatter_reduce_(1, target, most, "amax")
        best = (most == cells[:, _MOST].gather(1, target)) & (most > 0)
        batch, pair = best.nonzero(as_tuple=True)
        what[batch, target[batch, pair]] = step.pair_category[batch, pair].to(torch.int16)

    def _write_self(self, cells: Tensor, here: Tensor, step: MemoryStep) -> None:
        """Mark the agent's cell as visited, and the cell ahead as blocked after a collision."""
        rows = torch.arange(len(here), device=here.device)
        ahead = here + self.offsets[step.pose[:, 2].long(), :, (BEHIND + 1) * COLUMNS + ASIDE]
        own, next_ = (
            p.clamp(0, SIZE - 1).select(1, 0) * SIZE + p.clamp(0, SIZE - 1).select(1, 1) for p in (here, ahead)
        )
        bumped = cells[rows, 2, next_]
        cells[rows, 2, next_] = torch.where(step.collision, torch.full_like(bumped, 255), bumped)
        visits = CHANNELS.index("visited")
        cells[rows, visits, own] = (cells[rows, visits, own].int() + 64).clamp(max=255).to(torch.uint8)
        cells[rows, 0, own] = 255

    def read(self, state: State, pose: Tensor) -> Window:
        """Windows around agents at ``pose`` (B, 4); cells beyond the map count as unknown."""
        cells = state["cells"].view(len(pose), -1, SIZE, SIZE)
        here = (pose[:, :2].long() + HALF).clamp(0, SIZE - 1).tolist()
        window = torch.stack([_around(c, i, j) for c, (i, j) in zip(cells, here, strict=True)])
        free = (window[:, 2] == 0) | (window[:, CHANNELS.index("visited")] > 0)
        return Window(window, free)


def _around(cells: Tensor, i: int, j: int) -> Tensor:
    """The window (C, WINDOW, WINDOW) of a map (C, SIZE, SIZE) around cell (i, j)."""
    top, left = i - REACH, j - REACH
    part = cells[:, max(top, 0) : top + WINDOW, max(left, 0) : left + WINDOW]
    above, before = max(-top, 0), max(-left, 0)
    below, after = WINDOW - above - part.shape[1], WINDOW - before - part.shape[2]
    return functional.pad(part, (before, after, above, below)) if above or before or below or after else part


def coarse(cells: Tensor) -> Tensor:
    """Windows at half the resolution, with unknown space and frontiers.

    Args:
        cells: (N, C, W, W) uint8.

    Returns:
        (N, C + 2, (W + 1) / 2, (W + 1) / 2) float32 in [0, 1]: the largest value of each 2 x 2 block, the share of it
        that is unknown, and floor that borders on the unknown (frontiers).
    """
    unknown = functional.avg_pool2d(255.0 - cells[:, :1].float(), 2, ceil_mode=True) / 255.0
    even = functional.pad(
        cells, (0, cells.shape[3] % 2, 0, cells.shape[2] % 2)
    )  # pooled as bytes: a quarter of the time
    rows = torch.maximum(even[:, :, ::2], even[:, :, 1::2])
    pooled = torch.maximum(rows[..., ::2], rows[..., 1::2]).float() / 255.0
    frontier = functional.max_pool2d(unknown, 3, 1, 1) * pooled[:, 1:2]
    return torch.cat([pooled, unknown, frontier], 1)


assert ROWS * COLUMNS == N_CELLS
