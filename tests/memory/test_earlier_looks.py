"""Looks in earlier requests: when each place was last seen, from how near, and what probability that leaves it."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ucon.memory.earlier_looks import NEVER, REACHES_M, Looking
from ucon.memory.place_model import MISS, PlaceModel
from ucon.memory.sighting_log import SightingLog
from ucon.memory.watching import Watching, depth_along
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.recalled import Recalled, Remembering, points_of
from ucon.perception.mapping.map_kernels import look, look_from
from ucon.perception.mapping.semantic_map import SemanticMap, camera_of, frame_depth
from ucon.perception.places.hollows import ALL_OPEN
from ucon.perception.places.target_places import Places

sys.path.insert(0, str(Path(__file__).parents[1] / "perception"))
from toy import ToyEnv, two_rooms

#: Look around from the door of the living room.
AROUND = (2, 2, 2, 2)
INSIDE = 1


class Robot:
    """A robot that looks around in the home of boxes, request by request."""

    def __init__(self) -> None:
        self.known, self.looking = SemanticMap(target="teapot"), Looking()
        self.log = SightingLog()

    def request(self, time: int, actions: tuple[int, ...] = AROUND, start: tuple[int, int, int] = (14, 4, 2)) -> None:
        """Play one request; the robot always starts at the same pose, so the frame stays that of the first request."""
        self.known.search_again("teapot")
        self.looking.begin(1.0)
        env = ToyEnv(two_rooms(), "teapot", start)
        obs, info = env.reset()
        watching = Watching(self.log)
        self.frame(obs, info, watching)
        for action in actions:
            obs, _, _, _, info = env.step(action)
            self.frame(obs, info, watching)
        self.shown = watching.shown
        self.looking.end(time)

    def frame(self, obs: dict, info: dict, watching: Watching) -> None:
        self.known.update(obs, info)
        depth = self.known.body.farthest(frame_depth(obs, info))
        self.looking.look(self.known, depth)
        watching.look(self.known, depth)


@pytest.fixture
def robot() -> Robot:
    made = Robot()
    made.request(4)
    return made


def test_nothing_was_looked_at_before_the_first_request() -> None:
    points, when = Looking().begin(4.5)
    assert points.shape == (0, 4)
    assert when.shape == (0,)


def test_a_look_counts_for_what_is_seen_from_so_far(robot: Robot) -> None:
    """The farther a thing is recognised, the more places count as looked at; none beyond the largest reach."""
    shown = [robot.looking.begin(reach)[1] == 4 for reach in (0.5, *REACHES_M, 99.0)]
    counts = [int(one.sum()) for one in shown]
    assert counts[0] == 0
    assert counts == sorted(counts)
    assert counts[1] < counts[3] < counts[6] == counts[7]
    for near, far in pairwise(shown):
        assert not (near & ~far).any()
    points, when = robot.looking.begin(4.5)
    away = np.linalg.norm(points[:, :2], axis=1)[when == 4]
    assert away.max() <= 4.5 * np.sqrt(2.0), "within a reach of optical depth, seen at 45 degrees at most"


def test_a_reach_between_two_distances_is_the_smaller_one(robot: Robot) -> None:
    assert (robot.looking.begin(2.0)[1] == robot.looking.begin(1.6)[1]).all()
    assert (robot.looking.begin(2.1)[1] != robot.looking.begin(1.6)[1]).any()


def test_what_is_behind_a_closed_door_was_not_looked_at() -> None:
    """The cupboard in the kitchen, seen from right in front of it."""
    robot = Robot()
    robot.request(4, actions=(1, 1, 1, 1), start=(29, 15, 1))
    points, when = robot.looking.begin(4.5)
    (cupboard,) = robot.known.instances["bottom_cabinet"]
    x0, y0, z0, x1, y1, z1 = robot.known.box[cupboard]
    xyz, relation = points[:, :3], points[:, 3] / 100.0
    inside = (relation == INSIDE) & (xyz > [x0, y0, z0]).all(1) & (xyz < [x1, y1, z1]).all(1)
    assert inside.sum() > 2
    assert (when[inside] == NEVER).all()
    assert (when[~inside] == 4).any()


def test_times_stay_with_the_places_until_they_are_shown_again(robot: Robot) -> None:
    before, when = robot.looking.begin(4.5)
    robot.request(9, actions=())
    after, later = robot.looking.begin(4.5)
    assert set(later.tolist()) == {NEVER, 4, 9}
    assert (later == 9).sum() < (when == 4).sum()
    assert len(after) >= len(before)


def test_a_look_in_the_same_slot_leaves_nearly_nothing(robot: Robot) -> None:
    model = PlaceModel()
    _, when = robot.looking.begin(4.5)
    left = model.left(when, NEVER, 4)
    assert left[when == 4] == pytest.approx(MISS)
    assert (left[when == NEVER] == 1.0).all()
    later = [model.left(when, NEVER, time)[when == 4].max() for time in (4, 5, 7, 12, 60)]
    assert later == sorted(later)
    assert later[-1] > 0.99


def expected(robot: Robot, recalled: Recalled) -> tuple[np.ndarray, Places, Coverage]:
    places, inner = Places(0.1), Coverage("teapot", CoverageWeights())
    places.refresh(robot.known)
    return Remembering(inner, recalled).expect(robot.known, places).mass, places, inner


def test_looks_make_places_less_probable_and_shares_add_up(robot: Robot) -> None:
    points, when = robot.looking.begin(2.8)
    recalled = Recalled(np.zeros((0, 3)), np.zeros(0), (), points, PlaceModel().left(when, NEVER, 4))
    mass, places, inner = expected(robot, recalled)
    plain = inner.expect(robot.known, places).mass
    assert (mass <= plain + 1e-12).all()
    assert mass.sum() < 0.9 * plain.sum()
    kind = 4 * places.track + places.relation
    for share in (places.share, places.even):
        total = np.bincount(kind, share, mass.size)
        offered = np.bincount(kind, places.even, mass.size) > 0.0
        assert total[offered] == pytest.approx(1.0)
        assert not total[~offered].any()
    # Mass times share gives each point exactly what its look has left of it.
    left = np.ones(len(kind))
    left[looked_at(points, when, places)] = MISS
    mine = plain.ravel()[kind] * places.even * left
    assert places.weights(mass) == pytest.approx(mine * places.unseen)


def looked_at(points: np.ndarray, when: np.ndarray, places: Places) -> np.ndarray:
    """Indices of sample points whose nearest earlier point was looked at."""
    mine = points_of(places)
    away = np.linalg.norm(mine[:, None] - points[None], axis=2)
    return np.flatnonzero((away.min(1) < 0.3) & (when[away.argmin(1)] >= 0))


def test_divided_mass_adds_up_and_points_without_any_keep_their_shape(robot: Robot) -> None:
    places = Places(0.1)
    places.refresh(robot.known)
    rng = np.random.default_rng(0)
    mass = rng.uniform(0.0, 1.0, len(places.even)) * (places.even > 0.0)
    kind = 4 * places.track + places.relation
    none = kind == kind[np.flatnonzero(places.even > 0.0)[0]]
    mass[none] = 0.0
    places.divide(mass)
    total = np.bincount(kind, places.share)
    assert total[total > 0.0] == pytest.approx(1.0)
    assert (places.share[none] == places.even[none]).all()
    summed = np.bincount(kind, mass)[kind]
    some = summed > 0.0
    assert places.share[some] * summed[some] == pytest.approx(mass[some])
    places.divide(places.even.copy())
    assert places.share == pytest.approx(places.even)


def test_both_kernels_show_the_same_points() -> None:
    """``look_from`` notes the depth of exactly the points that ``look`` shows, and never raises it."""
    rng = np.random.default_rng(0)
    env, known = ToyEnv(two_rooms(), "teapot", (14, 4, 2)), SemanticMap(target="teapot")
    known.update(*(frame := env.reset()))
    depth = known.body.farthest(frame_depth(*frame))
    camera = camera_of(known.view, depth, known.body)
    n = 4000
    xyz = rng.uniform([-2.0, -3.0, 0.0], [5.0, 5.0, 2.2], (n, 3))
    hollow, faces, active = np.zeros((n, 6)), np.full(n, ALL_OPEN, np.uint8), rng.random(n) < 0.8
    for reach in (1.0, 2.5, 6.0):
        unseen, near = np.ones(n), np.full(n, reach)
        count = look(depth, camera, reach, xyz, hollow, faces, active, unseen, 0.0)
        look_from(depth, camera, xyz, hollow, faces, active, near)
        assert count == (unseen == 0.0).sum() > 5
        along = depth_along(xyz, camera)
        assert ((near < reach) == (unseen == 0.0)).all()
        assert near[near < reach] == pytest.approx(along[near < reach])
        assert not (near < reach)[~active].any()
        again = near.copy()
        look_from(depth, camera, xyz, hollow, faces, active, again)
        assert (again == near).all()


def test_watching_shows_places_that_are_in_view_and_near_enough() -> None:
    """A bowl is recognised from farther away than a battery, so its far place is shown and the battery's is not."""
    robot = Robot()
    robot.request(1)
    ahead, far = np.array([1.0, 0.0, 0.8]), np.array([1.9, 0.0, 0.8])
    for name in ("bowl", "battery"):
        robot.log.saw(name, ahead, 1)
        robot.log.saw(name, far, 1)
        robot.log.saw(name, -far, 1)
    robot.request(2, actions=())
    assert set(robot.shown) == {("bowl", 0), ("bowl", 1), ("battery", 0)}
