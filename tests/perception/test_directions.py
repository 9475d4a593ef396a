"""Sightings and directions: what single frames showed, and where one can go from a node."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from toy import Thing, ToyEnv, ToyHome, two_rooms

from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.detections import STRUCTURE_KINDS
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View
from ucon.perception.mapping.sightings import Sighting, Sightings
from ucon.perception.views.candidates import Candidate
from ucon.perception.views.heading_candidates import Goal, directions, in_view
from ucon.task.actions import Action
from ucon.task.sets import load_episodes


def around(env: object, sightings: Sightings, start: object = None) -> tuple[SemanticMap, Planner]:
    """The map and planner after turning left through all four headings."""
    obs, info = env.reset(options=start) if start else env.reset()  # type: ignore[attr-defined]
    known, planner = SemanticMap(), Planner(info.get("nav"))
    for turn in range(4):
        known.update(obs, info)
        sightings.look(known, obs, info)
        if turn < 3:
            obs, _, _, _, info = env.step(int(Action.ROTATE_LEFT))  # type: ignore[attr-defined]
    planner.update(known)
    return known, planner


@pytest.fixture(scope="module")
def homes() -> list[tuple[SemanticMap, Planner, Sightings]]:
    env = UcONEnv(load_episodes("mini")[::5], observe="symbolic", detector=True)
    out = []
    for number in range(len(env.episodes)):
        sightings = Sightings(floor=True)
        out.append((*around(env, sightings, {"episode": number}), sightings))
    return out


def test_sightings_come_by_heading_from_the_present_one_to_the_left(homes: list) -> None:
    for known, _, sightings in homes:
        found = sightings.of(known)
        assert [s.view.heading for s in found] == [(known.view.heading + k) % 4 for k in range(4)]
        assert {(s.view.i, s.view.j) for s in found} == {(known.view.i, known.view.j)}
        assert all(s.rgb is None for s in found)


def test_things_are_counted_ordered_and_no_structure() -> None:
    things = [Thing("bowl", (x, 3.0, 1.0, x + 0.2, 3.2, 1.2)) for x in (1.0, 2.0, 3.0)]
    env = ToyEnv(ToyHome(5.0, 5.0, [*things, Thing("sofa", (1.0, 4.2, 0.0, 4.0, 4.9, 1.0))]), "ring", (8, 4, 1))
    sightings = Sightings()
    obs, info = env.reset()
    known = SemanticMap()
    known.update(obs, info)
    sightings.look(known, obs, info)
    (seen,) = sightings.of(known)
    assert seen.things == (("sofa", 1), ("bowl", 3))
    assert seen.floor_xy is None
    assert "floors" in info["detections"]["category"]
    assert not {name for name, _ in seen.things} & set(STRUCTURE_KINDS)


def test_frames_of_other_nodes_and_tilted_ones_are_forgotten() -> None:
    env, sightings = ToyEnv(two_rooms(), "ring", (12, 4, 1)), Sightings()
    known, _ = around(env, sightings)
    assert len(sightings.of(known)) == 4
    for action, left in ((Action.LOOK_DOWN, 4), (Action.LOOK_UP, 4), (Action.MOVE_AHEAD, 1), (Action.ROTATE_LEFT, 2)):
        obs, _, _, _, info = env.step(int(action))
        known.update(obs, info)
        sightings.look(known, obs, info)
        assert len(sightings.of(known)) == left
        assert all(s.view.pitch_deg == 0 for s in sightings.of(known))


def test_the_middle_of_the_floor_is_floor_that_was_seen(homes: list) -> None:
    middles = 0
    for known, _, sightings in homes:
        for sighting in sightings.of(known):
            if sighting.floor_xy is None:
                continue
            i, j = (round(v / CELL_M) + HALF for v in sighting.floor_xy)
            assert known.floor[i - 1 : i + 2, j - 1 : j + 2].any()
            ahead = np.subtract(sighting.floor_xy, sighting.view.xy)
            c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[sighting.view.heading]
            assert c * ahead[0] + s * ahead[1] >= abs(s * ahead[0] - c * ahead[1]) - 1e-6
            middles += 1
    assert middles > 20


def test_of_two_patches_of_floor_the_larger_counts() -> None:
    """A bench across the view leaves a near patch and a far one."""
    bench = Thing("bench", (0.1, 3.0, 0.0, 5.9, 3.4, 0.5))
    middles = {}
    for depth, name in ((4.4, "near"), (40.0, "far")):
        env = ToyEnv(ToyHome(6.0, depth, [bench] if name == "near" else []), "ring", (11, 2, 1))
        sightings, known = Sightings(floor=True), SemanticMap()
        obs, info = env.reset()
        known.update(obs, info)
        sightings.look(known, obs, info)
        middles[name] = sightings.of(known)[0].floor_xy
    assert middles["near"] is not None
    assert middles["far"] is not None
    assert 0.9 < middles["near"][0] < 2.4  # in front of the bench, which begins 2.4 m ahead
    assert middles["far"][0] > middles["near"][0]
    assert abs(middles["near"][1]) < 1.5


def test_nodes_in_view_are_near_within_45_degrees_reachable_and_in_sight(homes: list) -> None:
    total = 0
    for known, planner, _ in homes:
        for heading in range(4):
            view = View(known.view.i, known.view.j, heading)
            nodes, distance = in_view(known, planner, view, (1.0, 5.0))
            c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[heading]
            d = (nodes - np.array([view.i, view.j])) * CELL_M
            ahead, aside = c * d[:, 0] + s * d[:, 1], s * d[:, 0] - c * d[:, 1]
            assert (np.abs(aside) <= ahead + 1e-9).all()
            assert np.hypot(ahead, aside) == pytest.approx(distance)
            assert ((distance >= 1.0) & (distance <= 5.0)).all()
            assert (planner.steps[nodes[:, 0], nodes[:, 1]].min(1) < UNREACHED).all()
            assert known.explored[nodes[:, 0], nodes[:, 1]].all()
            total += len(nodes)
    assert total > 500


def test_what_is_behind_a_wall_is_not_in_view() -> None:
    """The door is off to the side, so nothing in the room straight ahead behind the wall counts."""
    env, sightings = ToyEnv(two_rooms(), "ring", (16, 14, 0)), Sightings()
    known, planner = around(env, sightings)
    known.explored[:] = 1  # even if the other room were known
    wall = (5.5 - env.xy[0]) / CELL_M
    nodes, _ = in_view(known, planner, View(HALF, HALF, 0), (1.0, 5.0))
    straight = nodes[np.abs(nodes[:, 1] - HALF) <= 1]
    assert (straight[:, 0] - HALF <= wall).all()


@pytest.mark.parametrize(("start", "blocked"), [((1, 4, 2), {0}), ((12, 2, 3), {0}), ((1, 1, 2), {0, 1})])
def test_a_direction_with_a_wall_right_ahead_is_none(start: tuple[int, int, int], blocked: set[int]) -> None:
    sightings = Sightings()
    known, planner = around(ToyEnv(two_rooms(), "ring", start), sightings)
    found = directions(known, planner, sightings.of(known), "farthest", (1.0, 5.0), np.random.default_rng(0))
    assert {c.view.heading for c in found} == {0, 1, 2, 3} - blocked


def offered(known: SemanticMap, planner: Planner, seen: list[Sighting], goal: Goal, seed: int = 0) -> list[Candidate]:
    return directions(known, planner, seen, goal, (1.0, 5.0), np.random.default_rng(seed))


def test_goals_of_a_direction(homes: list) -> None:
    """Farthest, nearest to the middle of the floor, or random; always in view in that direction, with its sightings."""
    drawn = set()
    for known, planner, sightings in homes:
        seen = sightings.of(known)
        make = partial(offered, known, planner, seen)
        far, floor = make("farthest"), make("floor")
        assert [c.view for c in make("random", 1)] == [c.view for c in make("random", 1)]
        drawn.add(tuple(c.view for c in make("random", 1)) == tuple(c.view for c in make("random", 2)))
        by_heading = {s.view.heading: s for s in seen}
        for a, b in zip(far, floor, strict=True):
            nodes, distance = in_view(known, planner, by_heading[a.view.heading].view, (1.0, 5.0))
            assert a.free_m == b.free_m == round(distance.max(), 2)
            reached = np.hypot(*np.subtract(a.view.xy, known.view.xy))
            assert reached == pytest.approx(distance.max())
            assert a.things == by_heading[a.view.heading].things
            middle = by_heading[b.view.heading].floor_xy
            if middle is not None:
                gaps = np.hypot(*((nodes - HALF) * CELL_M - np.array(middle)).T)
                assert np.hypot(*np.subtract(b.view.xy, middle)) == pytest.approx(gaps.min())
    assert False in drawn
