"""What one frame shows: things and the cells of the patch around the agent."""

import numpy as np
import pytest

from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED, SEEN_FLOOR, mark_floor
from models.nets.end_to_end.ego_view import (
    AHEAD,
    ASIDE,
    BEHIND,
    CELL_M,
    COLUMNS,
    N_CELLS,
    THING_FEATURES,
    ego_view,
)


def flags_of(row: int, column: int, off_m: float) -> np.ndarray:
    """Bits of all cells for one obstacle in a cell, ``off_m`` to the left of the cell's node."""
    at = np.array([(row - BEHIND) * CELL_M, (column - ASIDE) * CELL_M + off_m, 0.5], np.float32)
    flags, nearest = np.zeros(N_CELLS, np.uint8), np.full(N_CELLS, np.inf, np.float32)
    cell = np.zeros((1, 1), np.int64)
    spread = np.full((1, 1), np.hypot(at[0], at[1]), np.float32)
    mark_floor(at.reshape(3, 1, 1), spread, 1, (AHEAD, ASIDE, BEHIND, COLUMNS), flags, nearest, cell)
    assert cell[0, 0] == row * COLUMNS + column
    assert nearest[cell[0, 0]] == spread[0, 0]
    return flags


@pytest.mark.parametrize("left", [-ASIDE, ASIDE])
def test_an_obstacle_at_one_edge_blocks_nothing_at_the_other(left: int) -> None:
    flags = flags_of(10, left + ASIDE, 0.1 * np.sign(left))
    assert np.flatnonzero(flags).tolist() == [10 * COLUMNS + left + ASIDE]


def test_an_obstacle_between_nodes_blocks_both() -> None:
    flags, at = flags_of(10, ASIDE, 0.12), 10 * COLUMNS + ASIDE
    assert np.flatnonzero(flags & BLOCKED).tolist() == [at, at + 1]
    assert np.flatnonzero(flags & EXPLORED).tolist() == [at]


def frame(**changes: object) -> tuple[np.ndarray, dict[str, object]]:
    """A wall two metres ahead with a cup on it, in pixels 8 to 23 of rows 24 to 39 of 64, and a larger clock."""
    tracks = np.full((64, 64), -1, np.int16)
    tracks[24:40, 8:24], tracks[4:24, 34:64] = 0, 1
    detections = {"track": np.array([1, 0]), "category": ["wall_clock", "coffee_cup"], "pixels": np.array([600, 256])}
    info = {"detections": detections | changes, "tracks": tracks, "opened": (1,)}
    return np.full((64, 64), 2.0, np.float32), info


def test_features_of_a_thing_by_hand() -> None:
    """Its centre is half a unit left of the axis at two metres: one metre to the left, level with the camera."""
    depth, info = frame()
    found = ego_view(depth, 0.0, 1.25, info, "coffee_cup")
    assert found.names == ("coffee_cup", "wall_clock"), "the target first, though it is smaller"
    cup = dict(zip(THING_FEATURES, found.things[0].tolist(), strict=True))
    assert cup == pytest.approx(
        {
            "ahead_m": 2.0,
            "left_m": 1.0,
            "up_m": 0.0,
            "nearest_m": np.hypot(2.0, 2.0 * (32 - 23.5) / 32),
            "sin": 1 / np.sqrt(5),
            "cos": 2 / np.sqrt(5),
            "u0": 8 / 64,
            "v0": 24 / 64,
            "u1": 24 / 64,
            "v1": 40 / 64,
            "pixels": np.log(256 * 4 / 64),
            "score": 1.0,
            "just_opened": 0.0,
        },
        abs=2e-3,
    )
    assert found.things[1, THING_FEATURES.index("just_opened")] == 1.0
    assert found.tracks[:3].tolist() == [0, 1, -1]
    assert ego_view(depth, 0.0, 1.25, info, "fridge").names == ("wall_clock", "coffee_cup"), "then the larger"


def test_scores_are_the_detectors_where_it_gives_any() -> None:
    depth, info = frame(score=np.array([0.25, 0.75]))
    found = ego_view(depth, 0.0, 1.25, info, "coffee_cup")
    assert found.things[:2, THING_FEATURES.index("score")].tolist() == [0.75, 0.25]


def test_cells_of_things_and_of_the_floor() -> None:
    """The cup is in the cell 8 ahead and 4 to the left; a wall two metres ahead hides everything behind it."""
    depth, info = frame()
    found = ego_view(depth, 0.0, 2.1, info, "coffee_cup")
    cell = (8 + BEHIND) * COLUMNS + 4 + ASIDE
    assert (found.pair_cell[0], found.pair_row[0]) == (cell, 0)
    cells = {(int(c), int(r)) for c, r in zip(found.pair_cell, found.pair_row, strict=True) if c >= 0}
    assert {c % COLUMNS - ASIDE for c, r in cells if r == 0} == {2, 3, 4, 5, 6}, "0.6 to 1.5 m to the left"
    assert {c % COLUMNS - ASIDE for c, r in cells if r == 1} == set(range(-8, 0)), "0.1 to 1.9 m to the right"
    assert {r for _, r in cells} == {0, 1}
    assert all(c // COLUMNS - BEHIND == 8 for c, _ in cells), "all that is seen is on the wall"
    ahead = found.patch[:, ASIDE] & EXPLORED
    assert ahead[BEHIND : BEHIND + 9].all()
    assert not ahead[BEHIND + 9 :].any()
    assert not (found.patch & SEEN_FLOOR).any(), "the lowest point in view is a tenth of a metre up"
