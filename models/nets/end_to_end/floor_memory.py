"""The map memory: where the agent has been, what it saw there, and what each pose on it would show.

A grid of 0.25 m cells around the start and a table of tracked things, kept in the recurrent state and written by fixed
rules from each frame's :mod:`models.nets.end_to_end.ego_view`: no parameters, no gradient, a pure function of the
sequence of frames. What the network reads of it is counted by :mod:`models.nets.end_to_end.outlook_kernels` and
:mod:`models.nets.end_to_end.memory_kernels`.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED
from models.nets.end_to_end.ego_view import BEHIND, COLUMNS
from models.nets.end_to_end.memory_kernels import (
    OPENED,
    TARGET,
    VISITED,
    measure_maps,
    write_floor,
    write_things,
)
from models.nets.end_to_end.outlook_kernels import N_OUTLOOK, KeptCounts, look_out
from models.nets.end_to_end.way_kernels import find_ways

HALF: Final = 128
SIZE: Final = 2 * HALF + 1
"""Cells per side of the map: 64 m, with the start in the middle."""
REACH: Final = 40
"""Poses up to this many cells to each side of the agent (10 m) are considered."""
BLOCKS: Final = REACH + 1
"""Blocks of 2 x 2 cells per side of the window around the agent."""
N_TRACKS: Final = 512
OUTLOOK: Final = ("on", "beside", "inside", "used", "closed", "space", "thin", "target", "been", "around")
"""Names of the counts of every pose (a cell and a heading).

In this order: belief that the target is on, beside or under, or in (open) what the pose would show and was not yet
looked at closely; all belief in what was; belief behind closed doors that Open would reach; square metres of unexplored
space, and of space seen from too far away; whether the target shows, less if farther away; how often the agent stood
near with this heading, and with any.
"""
TOTALS: Final = ("explored", "thin", "fresh")
"""Names of the sums over a map: square metres explored, those of them not seen closely, and the belief in these."""

#: Cells (i, j) ahead, to the right, to the left and here, by heading.
_BESIDE: Final = np.array([[(c, s), (s, -c), (-s, c), (0, 0)] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])

assert len(OUTLOOK) == N_OUTLOOK

State = dict[str, Tensor]


class MemoryStep(NamedTuple):
    """One frame of B episodes with K things in view, as it is written into their maps."""

    pose: Tensor
    """(B, 4) int: cell (i, j) relative to the start, heading in quarter turns, look up or down."""
    collision: Tensor
    """(B,) bool, the last move hit something."""
    patch: Tensor
    """(B, R, C) uint8, bits of :mod:`models.nets.end_to_end.ego_view`."""
    look: Tensor
    """(B, R, C) uint8, how closely each cell was seen."""
    pair_cell: Tensor
    """(B, P) int16, cell of the patch of each (thing, cell) pair; -1 for none."""
    pair_row: Tensor
    """(B, P) int16, number of the thing in the frame."""
    tracks: Tensor
    """(B, K) int16, -1 for none."""
    ids: Tensor
    """(B, K) int16, categories; -1 for none."""
    is_target: Tensor
    """(B, K) bool."""
    just_opened: Tensor
    """(B, K) bool, was opened by this step."""


class Outlook(NamedTuple):
    """Poses around B agents with what each would show, in C x C blocks of 2 x 2 cells along the map's axes."""

    counts: Tensor
    """(B, len(OUTLOOK), 4, C, C) float32, by heading; 0 where there is no way."""
    steps: Tensor
    """(B, 4, C, C) uint8, actions to get there, ``FAR`` where there is no way."""
    first: Tensor
    """(B, 4, C, C) uint8, the first of them; ``STAY`` where the agent is."""
    cell: Tensor
    """(B, C, C) uint8, which cell stands for each block: 2 * row + column."""
    totals: Tensor
    """(B, len(TOTALS)) float32."""
    beside: Tensor
    """(B, 8) float32: visits of the cells ahead, right, left and here in units of four, and which are free."""


def initial_maps(batch: int, device: torch.device) -> State:
    """Empty maps of B episodes, tensors (B, ...) by name."""

    def filled(value: float, dtype: torch.dtype, *shape: int) -> Tensor:
        return torch.full((batch, *shape), value, dtype=dtype, device=device)

    return {
        "flags": filled(0, torch.uint8, SIZE, SIZE),
        "look": filled(0, torch.uint8, SIZE, SIZE),
        "visits": filled(0, torch.uint8, 4, SIZE, SIZE),
        "who": filled(-1, torch.int16, 2, SIZE, SIZE),
        "kind": filled(-1, torch.int16, N_TRACKS),
        "extent": filled(0, torch.int32, N_TRACKS),
        "opened": filled(0, torch.bool, N_TRACKS),
    }


def write(state: State, step: MemoryStep, belief: Tensor, openable: Tensor) -> Tensor:
    """Write one step into the maps, in place.

    Args:
        state: maps as from :func:`initial_maps`, on the CPU.
        step: what was seen.
        belief: (B, n + 1, 4) float32, probability that the target is on, in, under or beside a thing of each category.
        openable: (n + 1,) bool, categories with doors.

    Returns:
        (B, N_TRACKS, 4) float32, belief of every track: on it, beside or under it, in it, behind its closed doors. The
        belief of a category is divided equally among its things.
    """
    known = (step.tracks >= 0) & (step.tracks < N_TRACKS) & (step.ids >= 0)
    batch, row = known.nonzero(as_tuple=True)
    track = step.tracks[batch, row].long()
    state["kind"][batch, track] = step.ids[batch, row]
    just = step.just_opened[batch, row]
    state["opened"][batch[just], track[just]] = True
    mass = track_belief(state, belief, openable)
    maps = {name: state[name].numpy() for name in ("flags", "look", "visits", "who", "extent")}
    pose = step.pose.to(torch.int32).numpy()
    write_floor(
        maps["flags"], maps["look"], maps["visits"], pose, step.collision.numpy(), step.patch.numpy(),
        step.look.numpy(), BEHIND,
    )  # fmt: skip
    write_things(
        maps["flags"], maps["who"], maps["extent"], mass.numpy(), pose, step.pair_cell.numpy(), step.pair_row.numpy(),
        step.tracks.numpy(), step.is_target.numpy(), state["opened"].numpy(), COLUMNS, BEHIND,
    )  # fmt: skip
    return mass


def track_belief(state: State, belief: Tensor, openable: Tensor) -> Tensor:
    """(B, N_TRACKS, 4) float32, belief of every track, as :func:`write` returns it."""
    kind = state["kind"].long()
    seen = kind >= 0
    kind = torch.where(seen, kind, belief.shape[1] - 1)
    alike = torch.zeros(belief.shape[:2], dtype=torch.float32).scatter_add_(1, kind, seen.float())
    share = seen / alike.gather(1, kind).clamp(min=1.0)
    ontop, inside, under, beside = (belief[..., k].gather(1, kind) * share for k in range(4))
    shut = openable[kind] & ~state["opened"]
    return torch.stack([ontop, under + beside, inside * ~shut, inside * shut], -1)


#: A patience that is never reached: at most 255 steps are counted in a pose.
ENDLESS: Final = 256


def kept_counts() -> KeptCounts:
    """An empty cache for :func:`outlook`."""
    return KeptCounts(SIZE)


def outlook(
    state: State, mass: Tensor, pose: Tensor, reach_m: Tensor, patience: int = ENDLESS, kept: KeptCounts | None = None
) -> Outlook:
    """Count what each pose around the agents would show.

    Args:
        state: maps, on the CPU.
        mass: (B, N_TRACKS, 4) of :func:`write`.
        pose: (B, 4) int.
        reach_m: (B,) distance from which the target would be seen, metres.
        patience: a pose that the agent has spent this many steps in counts as showing nothing more.
        kept: cache of counts, which saves time where each row continues its episode. None: no cache.
    """
    n = len(pose)
    share = (mass / state["extent"].clamp(min=1)[..., None]).numpy()
    flags, look, visits, who, extent = (state[k].numpy() for k in ("flags", "look", "visits", "who", "extent"))
    at = pose.to(torch.int32).numpy()
    sight = (reach_m * 4.0).to(torch.int32).numpy()
    enough = (255.0 * torch.exp(-reach_m / 2.0)).to(torch.uint8).numpy()
    steps, first = (np.empty((n, 4, BLOCKS, BLOCKS), np.uint8) for _ in range(2))
    cell = np.empty((n, BLOCKS, BLOCKS), np.uint8)
    find_ways(flags, at, REACH, steps, first, cell)
    counts = np.empty((n, N_OUTLOOK, 4, BLOCKS, BLOCKS), np.float32)
    cached = (kept or kept_counts()).of(n)
    look_out(flags, look, who, visits, share, extent, at, sight, enough, steps, cell, patience, cached, counts)
    totals = np.empty((n, len(TOTALS)), np.float32)
    measure_maps(flags, look, who, share, enough, totals)
    found: list[Any] = [counts, steps, first, cell, totals, _beside(flags, visits, at)]
    return Outlook(*(torch.from_numpy(array) for array in found))


def layers(state: State, mass: Tensor) -> dict[str, NDArray[np.uint8]]:
    """The map of one episode for drawing: (SIZE, SIZE) uint8 by name, 255 where a property holds.

    ``most`` is 255 times the square root of each cell's highest belief relative to the map's highest.

    Args:
        state: maps of one episode (1, ...).
        mass: (1, N_TRACKS, 4) of :func:`track_belief`.
    """
    flags = state["flags"][0].numpy()
    bits = {"explored": EXPLORED, "blocked": BLOCKED, "opened": OPENED, "target": TARGET, "visited": VISITED}
    drawn = {name: np.where(flags & bit, 255, 0).astype(np.uint8) for name, bit in bits.items()}
    most = cell_belief(state, mass).max(0)
    drawn["most"] = (255 * np.sqrt(most / max(float(most.max()), 1e-9))).astype(np.uint8)
    return drawn


def cell_belief(state: State, mass: Tensor) -> NDArray[np.float32]:
    """(2, SIZE, SIZE) float32, belief of the two things in each cell of one episode's map."""
    who = state["who"][0].long()
    found: NDArray[np.float32] = torch.where(who >= 0, mass[0].sum(-1)[who.clamp(min=0)], 0.0).numpy()
    return found


def _beside(flags: NDArray[np.uint8], visits: NDArray[np.uint8], pose: NDArray[np.int32]) -> NDArray[np.float32]:
    at = np.clip(pose[:, None, :2] + HALF + _BESIDE[pose[:, 2] & 3], 0, SIZE - 1)  # (B, 4, 2)
    row = np.arange(len(pose))[:, None]
    seen = flags[row, at[..., 0], at[..., 1]]
    often = visits[row, :, at[..., 0], at[..., 1]].astype(np.float32).sum(-1)
    free = (seen & BLOCKED == 0) | (seen & VISITED > 0)
    return np.concatenate([np.minimum(0.25 * often, 1.0), free], 1).astype(np.float32)
