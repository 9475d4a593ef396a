from __future__ import annotations

import numpy as np
import pytest
from toy import CELL, ToyEnv, two_rooms

from ucon.core.errors import ConfigError
from ucon.perception.drawing.map_picture import draw_map
from ucon.perception.mapping import map_kernels
from ucon.perception.mapping.semantic_map import HALF, SIZE, SemanticMap, View, view_of_pose

#: Look around, walk through the door, look around again, with some blocked moves and looks down.
TOUR = [2, 2, 2, 2, *[0] * 5, 2, 1, 1, *[0] * 20, 4, 1, 1, 1, 1, 3, *[0] * 6, 1, 0, 0, 0, 1, 4, 1, 1]


@pytest.fixture(params=[0, 1, 2, 3], scope="module")
def toured(request: pytest.FixtureRequest) -> tuple[ToyEnv, SemanticMap]:
    env = ToyEnv(two_rooms(), "ring", (14, 4, request.param))
    known = SemanticMap()
    known.update(*env.reset())
    for action in TOUR:
        obs, _, _, _, info = env.step(action)
        known.update(obs, info)
    return env, known


def to_world(env: ToyEnv, x: float, y: float) -> tuple[float, float]:
    """A point of the agent's frame in the toy's frame."""
    c, s = (1, 0, -1, 0)[env.start[2]], (0, 1, 0, -1)[env.start[2]]
    return (env.start[0] + 0.5) * CELL + c * x - s * y, (env.start[1] + 0.5) * CELL + s * x + c * y


def test_boxes_lie_within_the_truth(toured: tuple[ToyEnv, SemanticMap]) -> None:
    env, known = toured
    tracks = {track: k for k, track in env.tracks.items()}
    checked = 0
    for track in range(known.n_tracks):
        thing = env.things[tracks[track]]
        assert known.category[track] == thing.category
        if known.kind[track] or not known.seen(track):
            continue
        x0, y0, z0, x1, y1, z1 = known.box[track]
        corners = np.array([to_world(env, x, y) for x in (x0, x1) for y in (y0, y1)])
        low, high = np.array(thing.box[:3]), np.array(thing.box[3:])
        assert (corners.min(0) >= low[:2] - 1e-3).all()
        assert (corners.max(0) <= high[:2] + 1e-3).all()
        assert low[2] - 1e-3 <= z0 <= z1 <= high[2] + 1e-3
        checked += 1
    assert checked >= 5


def test_observed_nodes_agree_with_the_true_grid(toured: tuple[ToyEnv, SemanticMap]) -> None:
    env, known = toured
    wrong_blocked = missed = seen = 0
    for i, j in np.argwhere(known.floor > 0):
        x, y = to_world(env, (i - HALF) * CELL, (j - HALF) * CELL)
        a, b = int(x / CELL), int(y / CELL)
        if not (0 <= a < env.free.shape[0] and 0 <= b < env.free.shape[1]):
            continue
        seen += 1
        wrong_blocked += bool(known.blocked[i, j]) and bool(env.free[a, b])
        missed += not known.blocked[i, j] and not env.free[a, b]
    assert seen > 200
    assert wrong_blocked == 0
    assert missed < 0.1 * seen


def test_walls_stand_on_cell_borders(toured: tuple[ToyEnv, SemanticMap]) -> None:
    env, known = toured
    for axis, i, j in np.argwhere(known.walls > 0):
        step = (0.5, 0.0) if axis == 0 else (0.0, 0.5)
        x, y = to_world(env, (i - HALF + step[0]) * CELL, (j - HALF + step[1]) * CELL)
        solid = [t.box for t in env.things if t.category == "walls"]
        assert any(b[0] - 0.01 <= x <= b[3] + 0.01 and b[1] - 0.01 <= y <= b[4] + 0.01 for b in solid)
    assert np.count_nonzero(known.walls) > 30


def test_pose_and_collisions(toured: tuple[ToyEnv, SemanticMap]) -> None:
    env, known = toured
    x, y = to_world(env, *known.view.xy)
    assert (x, y) == pytest.approx(env.xy)
    assert known.view.heading == (env.h - env.start[2]) % 4
    assert known.view.pitch_deg == env.pitch
    for i, j in np.argwhere(known.bumped > 0):
        x, y = to_world(env, (i - HALF) * CELL, (j - HALF) * CELL)
        a, b = int(np.floor(x / CELL)), int(np.floor(y / CELL))
        inside = 0 <= a < env.free.shape[0] and 0 <= b < env.free.shape[1]
        assert not (inside and env.free[a, b])


def test_another_angle_of_view_is_refused() -> None:
    obs, info = ToyEnv(two_rooms(), "ring", (14, 4, 0)).reset()
    SemanticMap().update(obs, {**info, "fov_deg": 90.0})
    with pytest.raises(ConfigError, match=r"env\.fov_deg=60"):
        SemanticMap().update(obs, {**info, "fov_deg": 60.0})


@pytest.mark.parametrize("heading", range(4))
def test_view_of_pose(heading: int) -> None:
    yaw = (0.0, np.pi / 2, np.pi, -np.pi / 2)[heading]
    pose = np.array([-1.25, 0.5, yaw, np.deg2rad(-30)], np.float32)
    assert view_of_pose(pose) == View(HALF - 5, HALF + 2, heading, -30)


def test_picture_shows_what_was_seen(toured: tuple[ToyEnv, SemanticMap]) -> None:
    _env, known = toured
    picture = draw_map(known, target="bowl", names=True)
    i0, i1, j0, j1 = known.extent()
    assert picture.shape == (8 * (j1 - j0), 8 * (i1 - i0), 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 5


@pytest.mark.parametrize(
    ("point", "border"),
    [
        ((0.1, 0.0), (0, 2, 2)),
        ((-0.1, 0.0), (0, 1, 2)),
        ((0.0, 0.1), (1, 2, 2)),
        ((0.0, -0.1), (1, 2, 1)),
        ((0.0, 0.0), None),
        ((0.1, 0.1), None),
        ((-0.1, 0.1), None),
    ],
)
def test_a_wall_point_marks_the_border_that_it_lies_by(point: tuple[float, float], border: tuple | None) -> None:
    walls = np.zeros((2, 5, 5), np.uint8)
    map_kernels._wall(walls, 2, 2, *point)
    assert [tuple(at) for at in np.argwhere(walls).tolist()] == ([] if border is None else [border])


@pytest.mark.parametrize(("heading", "ahead"), [(0, (1, 0)), (1, (0, 1)), (2, (-1, 0)), (3, (0, -1))])
def test_a_bump_is_noted_ahead(heading: int, ahead: tuple[int, int]) -> None:
    known = SemanticMap()
    known._bump(View(HALF + 3, HALF - 2, heading))
    assert np.argwhere(known.bumped).tolist() == [[HALF + 3 + ahead[0], HALF - 2 + ahead[1]]]
    for i, j in ((0, 0), (SIZE - 1, SIZE - 1)):
        known._bump(View(i, j, heading))
    assert known.bumped.sum() == 2, "what lies outside is not noted elsewhere"
