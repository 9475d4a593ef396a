"""What one frame shows: at the edges of the patch."""

import numpy as np
import pytest

from models.nets.ego_view import ASIDE, BLOCKED, COLUMNS, N_CELLS, _block


@pytest.mark.parametrize("left", [-ASIDE, ASIDE])
def test_an_obstacle_at_one_edge_blocks_nothing_at_the_other(left: int) -> None:
    flags = np.zeros(N_CELLS, np.uint8)
    at = np.array([10 * COLUMNS + left + ASIDE])
    _block(flags, at, np.array([[0.0], [0.1 * np.sign(left)]], np.float32))
    assert np.flatnonzero(flags).tolist() == at.tolist()


def test_an_obstacle_between_nodes_blocks_both() -> None:
    flags = np.zeros(N_CELLS, np.uint8)
    at = np.array([10 * COLUMNS + ASIDE])
    _block(flags, at, np.array([[0.0], [0.12]], np.float32))
    assert np.flatnonzero(flags == BLOCKED).tolist() == [at[0], at[0] + 1]
