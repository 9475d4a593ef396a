from __future__ import annotations

import numpy as np
import pytest
from toy import ToyEnv, two_rooms

from ucon.objects import catalogue
from ucon.perception.mapping.body import PAPER_BODY
from ucon.perception.mapping.map_kernels import shows
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View, frame_depth
from ucon.perception.places.affordances import affordance, has_room, sight_range_m, with_fallback
from ucon.perception.places.containers import Containers, open_reach_m
from ucon.perception.places.place_kernels import INSIDE, NEXTTO
from ucon.perception.places.target_places import Places
from ucon.perception.views.approach import Approach
from ucon.perception.views.view_kernels import sight
from ucon.perception.views.viewpoints import Expectation, Viewpoints

CAMERA_M = PAPER_BODY.camera_m


def started(target: str = "ring") -> tuple[ToyEnv, SemanticMap, Planner, dict]:
    env = ToyEnv(two_rooms(), target, (14, 4, 2))
    known = SemanticMap()
    obs, info = env.reset()
    known.update(obs, info)
    planner = Planner(info["nav"])
    planner.update(known)
    return env, known, planner, obs | info


@pytest.mark.parametrize("name", catalogue().names)
def test_every_category_has_a_range_and_somewhere_to_be(name: str) -> None:
    assert 1.0 < sight_range_m(name) < 5.0
    mass = with_fallback(np.array([[0.4, 0.3, 0.2, 0.1]]), [name])[0]
    assert mass.sum() == pytest.approx(1.0)
    assert (mass[:3][~affordance(name).offers] == 0).all()
    assert mass[NEXTTO] >= 0.1


def test_has_room() -> None:
    assert has_room("coffee_cup", "bottom_cabinet") == (True, True, True)
    assert not has_room("sofa", "bottom_cabinet")[1]
    assert not has_room("bed", "coffee_table")[0]


def test_looking_lowers_what_is_shown_and_only_that() -> None:
    _, known, _, frame = started()
    places = Places(0.1)
    places.refresh(known)
    active = places.share > 0
    shown = places.look(known, frame_depth(frame, frame), active, 3.0, 0.1)
    lowered = places.unseen < 1.0
    assert shown == lowered.sum() > 0
    x, _y = known.view.xy
    ahead = places.xyz[:, 0] - x
    assert (ahead[lowered] > 0).all()
    assert (ahead[lowered] <= 3.0).all()


def test_shares_add_up() -> None:
    env, known, _, _ = started()
    places = Places(0.1)
    for action in (2, 2, 2, 0, 0, 2, 0, 0):
        obs, _, _, _, info = env.step(action)
        known.update(obs, info)
        places.refresh(known)
    total = np.zeros((known.n_tracks, 4))
    np.add.at(total, (places.track, places.relation), places.share)
    live = total[total > 0]
    assert live == pytest.approx(1.0)


def test_walls_block_sight() -> None:
    env, known, _, _ = started()
    for action in (2, 2, 2, 2):
        obs, _, _, _, info = env.step(action)
        known.update(obs, info)
    i, j = np.argwhere(known.walls[0] > 0)[0]
    x, y = (i - HALF + 0.5) * 0.25, (j - HALF) * 0.25
    assert not sight(x - 0.6, y, CAMERA_M, x + 0.2, y, 1.0, known.height, known.walls, HALF)


def test_the_best_view_faces_the_mass() -> None:
    _, known, planner, _ = started()
    places = Places(0.1)
    places.refresh(known)
    track = known.instances["sofa"][0]
    mass = np.zeros((known.n_tracks, 4))
    mass[track, 0] = 1.0
    nothing_else = Expectation(mass, 0.0, 0.0)
    best, _ = Viewpoints(2.0).choose(known, planner, places, nothing_else, np.zeros(0, np.int64))
    assert best is not None
    assert best.gain > 0.1
    middle = 0.5 * (known.box[track, :2] + known.box[track, 3:5])
    heading = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][best.view.heading])
    assert (middle - best.view.xy) @ heading > 0


def test_approach_ends_in_success() -> None:
    env, known, planner, _ = started("bowl")
    for _ in range(4):
        obs, _, _, _, info = env.step(2)
        known.update(obs, info)
    track = known.instances["bowl"][0]
    approach = Approach()
    planner.update(known)
    goal = approach.goal(known, planner, track)
    assert goal is not None
    for action in planner.plan(goal):
        obs, _, _, _, info = env.step(int(action))
        known.update(obs, info)
    assert approach.arrived(known, track)
    assert env.in_reach()


def with_thing(category: str, box: tuple[float, ...]) -> tuple[SemanticMap, Places, np.ndarray]:
    _, known, _, _ = started()
    track = known.n_tracks
    known.category.append(category)
    known.box[track] = box
    places = Places(0.1)
    places.refresh(known)
    inside = (places.track == track) & (places.relation == INSIDE) & (places.share > 0)
    assert inside.any()
    return known, places, inside


def seen_from(places: Places, rows: np.ndarray, x: float, y: float) -> float:
    """Share of points that a camera at (x, y) sees through an open side."""
    found = [
        shows(x, y, CAMERA_M, *places.xyz[k], places.hollow[k], places.faces[k]) for k in np.flatnonzero(rows).tolist()
    ]
    return float(np.mean(found))


def test_who_looks_into_a_bin_must_stand_by_it() -> None:
    x, y = started()[1].view.xy
    _, places, inside = with_thing("trash_can", (x + 1, y, 0.0, x + 1.36, y + 0.38, 0.45))
    assert seen_from(places, inside, x + 1.18, y + 0.6) > 0.3
    assert seen_from(places, inside, x - 1.0, y + 0.15) == 0.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_closed_front_has_its_inside_behind_it(side: float) -> None:
    x, y = started()[1].view.xy
    front = x + side
    _, places, inside = with_thing("fridge", (front - 0.01, y - 0.4, 0.0, front + 0.01, y + 0.4, 1.7))
    assert (side * (places.xyz[inside, 0] - front) > 0.15).all()


def test_what_was_not_seen_stays_behind_what_was() -> None:
    """The front is judged again as more floor is seen, but the interior must not change sides with it."""
    x, y = started()[1].view.xy
    _, known, _, _ = started()
    known.category.append("fridge")
    track = known.n_tracks - 1
    known.box[track] = (x + 2.0, y - 0.35, 0.0, x + 2.05, y + 0.35, 1.7)
    places = Places(0.1)
    places.refresh(known)
    known.views.append(View(known.view.i + 20, known.view.j, 2))
    i, j = known.cells_of(np.array([track]))[0]
    for turn in range(2):
        known.floor[:], known.blocked[:] = 0, 0
        known.floor[i - 6 : i if turn == 0 else i + 7, j - 3 : j + 4] = 1
        known.blocked[i + (1 if turn == 0 else -6) : i + (7 if turn == 0 else 0), j - 3 : j + 4] = 1
        places.refresh(known)
        inside = (places.track == track) & (places.relation == INSIDE) & (places.share > 0)
        assert (places.xyz[inside, 0] > x + 2.05).all()
        assert (places.faces[inside] == (1 if turn == 0 else 2)).all()


def test_what_is_larger_is_seen_from_farther() -> None:
    """A cube of s metres covers s^2 f^2 / d^2 pixels of a view with focal length f = 64 at distance d."""
    side = 0.1  # the size of a name outside the catalogue
    assert sight_range_m("unicorn") == pytest.approx(64.0 * side / np.sqrt(5.0))
    assert sight_range_m("unicorn", 20.0) == pytest.approx(64.0 * side / np.sqrt(20.0))
    assert sight_range_m("unicorn", 1e6) == 1.2, "never nearer than that"
    assert sight_range_m("sofa") == 4.5, "never farther"


@pytest.mark.parametrize("name", ["sofa", "fridge", "coffee_cup", "bed"])
def test_nothing_has_no_room_for_its_like(name: str) -> None:
    """A thing of the same size fits into the thing's box exactly, turned if necessary."""
    assert has_room(name, name)[1]


def test_open_reaches_a_little_less_far_than_the_body() -> None:
    _, known, _, _ = started()
    assert 0.9 * known.body.near_m < open_reach_m(known) < known.body.near_m


def test_containers_that_were_never_detected_or_were_opened_are_not_closed() -> None:
    _, known, _, _ = started()
    containers = Containers()
    before = set(containers.closed(known).tolist())
    first, second = known.n_tracks, known.n_tracks + 1
    known.category += ["fridge", "fridge"]
    known.box[first] = (1.0, 1.0, 0.0, 1.7, 1.7, 1.8)  # the second has no box, since no point of it was seen
    assert set(containers.closed(known).tolist()) == before | {first}
    known.opened[first] = True
    assert second not in containers.closed(known)
    assert set(containers.closed(known).tolist()) == before
