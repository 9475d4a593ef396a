"""Kernels that handle many things at once agree with handling them one by one, on maps of real episodes."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy

import cv2
import numpy as np
import pytest

from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.map_kernels import carve
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CARVE_M, CELL_M, HALF, SIZE, SemanticMap, View, camera_of
from ucon.perception.places.affordances import affordance
from ucon.perception.places.target_places import Places
from ucon.perception.views.approach import DRAWER_NEAR_M, Approach
from ucon.perception.views.approach_kernels import FAILED_COST, SMALL_COST, UNSEEN_COST
from ucon.perception.views.candidates import candidates, frontiers
from ucon.perception.views.space_kernels import OPAQUE_M
from ucon.perception.views.view_kernels import sight
from ucon.search import STRATEGIES, Explorer

Known = tuple[SemanticMap, Planner, Places]


@pytest.fixture(scope="module")
def maps() -> list[Known]:
    """Maps from three episodes, at every second choice."""
    return [known for episode in (1, 8, 40) for known in list(_choices(episode))[::2]]


def _choices(episode: int) -> Iterator[Known]:
    planner = "observed" if episode == 8 else "true"
    env = UcONEnv("mini", habit_level="none", planner=planner, observe="symbolic", detector=True)
    draw = np.random.default_rng(episode)
    obs, info = env.reset(options={"episode": episode})
    explorer, over = Explorer(info, STRATEGIES["landmarks"](info)), False
    while not over:
        action = explorer.look(obs, info)
        if action is None:
            offered = explorer.decision().candidates  # updates the planner
            yield deepcopy((explorer.map, explorer.planner, explorer.strategy._places))  # type: ignore[attr-defined]
            action = explorer.choose(int(draw.integers(len(offered))))
        obs, _, terminated, truncated, info = env.step(int(action))
        over = terminated or truncated


def middle(box: np.ndarray) -> np.ndarray:
    return 0.5 * (box[:3] + box[3:])


def reach_m(known: SemanticMap, track: int) -> float:
    x, y = middle(known.box[track])[:2]
    for holder in np.flatnonzero(known.opened[: known.n_tracks]).tolist():
        above = known.box[track, 2] >= known.box[holder, 5] + 0.05
        if affordance(known.category[holder]).drawers and not above and known.gap_m(holder, (x, y)) < 0.7:
            return DRAWER_NEAR_M
    return known.body.near_m - 0.005


def poses(known: SemanticMap, track: int) -> Iterator[tuple[View, float, float]]:
    """Poses on explored nodes in reach with a thing in view; for each, the thing's depth and the camera's height."""
    x, y, z = middle(known.box[track])
    for i, j in np.argwhere(known.explored > 0).tolist():
        if known.gap_m(track, View(i, j, 0).xy) > reach_m(known, track):
            continue
        dx, dy = x - (i - HALF) * CELL_M, y - (j - HALF) * CELL_M
        for heading in range(4):
            c, s = (1, 0, -1, 0)[heading], (0, 1, 0, -1)[heading]
            for look, (eye_m, pitch_deg) in known.body.eyes.items():
                cp, sp = np.cos(np.deg2rad(pitch_deg)), np.sin(np.deg2rad(pitch_deg))
                flat, rise = c * dx + s * dy, z - eye_m
                optical = cp * flat + sp * rise
                if optical > 0.1 and max(abs(s * dx - c * dy), abs(cp * rise - sp * flat)) <= 0.93 * optical:
                    yield View(i, j, heading, look), optical, eye_m


def cheapest(
    known: SemanticMap, planner: Planner, track: int, seen: tuple[float, float], failed: dict[View, int]
) -> tuple[int, View | None]:
    """The first of the cheapest poses from which to see a thing, by plainly adding up the costs."""
    best: tuple[int, View | None] = UNREACHED, None
    for view, optical, eye_m in poses(known, track):
        cost = planner.cost(view) + FAILED_COST * failed.get(view, 0)
        cost += SMALL_COST if seen[0] * (seen[1] / optical) ** 2 < 6.0 else 0
        shown = sight(*view.xy, eye_m, *middle(known.box[track]), known.height, known.walls, HALF)
        cost += 0 if shown else UNSEEN_COST
        if cost < best[0]:
            best = cost, view
    return best


def test_where_to_stand_for_all_things(maps: list[Known]) -> None:
    found = without = 0
    for known, planner, _ in maps:
        tracks = np.array([k for k in range(known.n_tracks) if known.seen(k) and not known.kind[k]][::3])
        approach, seen, failed = Approach(), (0.0, 1.0), {}
        for turn in range(2):
            views, costs = approach.goals(known, planner, tracks)
            for track, view, cost in zip(tracks.tolist(), views.tolist(), costs.tolist(), strict=True):
                if known.pixels[track] > seen[0]:
                    gap = middle(known.box[track]) - (*known.view.xy, known.body.eyes[known.view.pitch_deg][0])
                    seen = float(known.pixels[track]), float(np.linalg.norm(gap))
                expected = cheapest(known, planner, track, seen, failed)
                assert (cost, View(*view) if cost < UNREACHED else None) == expected
                assert turn or approach.goal(known, planner, track) == expected[1]
                found, without = found + (cost < UNREACHED), without + (cost >= UNREACHED)
            failed = {View(*view): 1 for view in views[::2].tolist()}  # these poses failed: again, from others
            for view in failed:
                approach.failed(view)
    assert found > 100
    assert without > 0


def test_which_things_are_offered(maps: list[Known]) -> None:
    for known, planner, places in maps:
        offered = {c.track: c for c in candidates(known, planner, places) if c.kind != "frontier"}
        left, total = np.zeros((known.n_tracks, 4)), np.zeros((known.n_tracks, 4))
        np.add.at(left, (places.track, places.relation), places.share * places.unseen)
        np.add.at(total, (places.track, places.relation), places.share)
        share = left.sum(1) / np.maximum(total.sum(1), 1e-9)
        assert (places.unseen_share(known.n_tracks) == share).all()
        wanted = set()
        for track, name in enumerate(known.category):
            has = affordance(name)
            closed = has.openable and not known.opened[track]
            if known.seen(track) and not known.kind[track] and (closed or (has.furniture and share[track] > 0.3)):
                wanted.add(track)
        reached = {t for t in wanted if any(planner.cost(v) < UNREACHED for v, _, _ in poses(known, t))}
        assert set(offered) == reached
        assert all(c.cost == planner.cost(c.view) for c in offered.values())


def facing_unknown(cells: np.ndarray, known: SemanticMap, planner: Planner) -> View:
    i, j = cells[np.abs(cells - cells.mean(0)).sum(1).argmin()].tolist()
    votes = []
    for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        near = np.clip(cells + np.array(step), 0, SIZE - 1)
        votes.append(np.count_nonzero(known.explored[near[:, 0], near[:, 1]] == 0))
    return View(i, j, min(range(4), key=lambda h: (-votes[h], planner.steps[i, j, h], h)))


def test_frontiers_group_by_group(maps: list[Known]) -> None:
    for known, planner, _ in maps:
        unknown = ((known.explored == 0) & (known.height < OPAQUE_M)).astype(np.uint8)
        beside = cv2.dilate(unknown, np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], np.uint8)) > 0
        edge = beside & (known.explored > 0) & (planner.steps.min(2) < UNREACHED)
        count, label = cv2.connectedComponents(edge.astype(np.uint8), connectivity=8)
        groups = [np.argwhere(label == number) for number in range(1, count)]
        expected = {(facing_unknown(cells, known, planner), len(cells)) for cells in groups if len(cells) >= 3}
        assert {(c.view, c.cells) for c in frontiers(known, planner)} == expected


@pytest.mark.parametrize("pitch_deg", [-30, 0, 30])
@pytest.mark.parametrize("pixels", [84, 128])
def test_sight_lines_one_by_one(maps: list[Known], pitch_deg: int, pixels: int) -> None:
    """Also with 84 pixels, where lines run exactly through corners of cells."""
    draw, body = np.random.default_rng(0), maps[0][0].body
    for heading in range(4):
        depth = draw.uniform(0.0, 12.0, (pixels, pixels)).astype(np.float32)
        camera = camera_of(View(HALF + 3, HALF - 5, heading, pitch_deg), depth, body)
        explored, expected = np.zeros((SIZE, SIZE), np.uint8), np.zeros((SIZE, SIZE), np.uint8)
        fresh = carve(depth, camera, HALF, explored, CARVE_M)
        x, y, _, c, s, cp, sp, focal_px = camera
        for v in range(4, pixels, 8):
            ahead = cp - sp * (0.5 * pixels - v - 0.5) / focal_px
            for u in range(0, pixels, 2):
                f, right = depth[v, u] * ahead, float(depth[v, u]) * ((u + 0.5 - 0.5 * pixels) / focal_px)
                way = np.array([c * f + s * right, s * f - c * right])
                length = np.sqrt(way[0] * way[0] + way[1] * way[1])
                if length > 0.15:
                    steps = np.arange(int(min(length - 0.02, CARVE_M) / 0.125) + 1)[:, None]
                    cells = np.floor((np.array([x, y]) + steps * (0.125 / length * way)) / CELL_M + 0.5).astype(int)
                    expected[tuple((cells + HALF).T)] = 1
        assert (explored == expected).all()
        assert fresh == expected.sum() > 50
