"""Every home: rooms, openings, items, windows, walking, determinism; checked by the audit, not the generator."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from audit import box_of, nav_grid, overlap, problems, walk_problems

from tests.timing import fastest_s, where_it_was_set
from ucon.core.errors import UconError
from ucon.objects.models import build_model
from ucon.scenes import SCENES, built_home, home_spec, scene_split
from ucon.scenes.plan import draw_plan
from ucon.scenes.program import HOME_KINDS, scene_programs
from ucon.scenes.spec import GRID_M, HomeSpec

FACTS = Path(__file__).resolve().parents[3] / "shared" / "facts" / "scenes.json"
SEEDS = 20
"""Generated homes of each kind in the fast tests: 100 in all."""


def procedural(n: int) -> list[str]:
    return [f"procedural:{kind}:{seed}" for seed in range(n) for kind in HOME_KINDS]


def test_there_are_22_scenes_and_two_are_unseen() -> None:
    assert len(SCENES) == 22
    assert [s for s in SCENES if scene_split(s) == "unseen"] == ["Beechwood_1_int", "Pomaria_1_int"]
    assert scene_split("Pomaria_1_int~4") == "unseen"
    assert scene_split("procedural:house:899999") == "seen"
    assert scene_split("procedural:house:900000") == "unseen"


@pytest.mark.parametrize("scene", SCENES)
def test_scene_is_sound(scene: str) -> None:
    assert problems(home_spec(scene)) == []


@pytest.mark.parametrize("scene", SCENES)
def test_variant_is_sound_and_differs(scene: str) -> None:
    variant = home_spec(f"{scene}~1")
    assert problems(variant) == []
    base = home_spec(scene)
    assert variant.items != base.items
    legs = {r.name for r in base.rooms} ^ {r.name for r in variant.rooms}
    assert all(name.endswith("_b") for name in legs), "a variant has the same rooms"


@pytest.mark.parametrize("name", procedural(SEEDS))
def test_generated_home_is_sound(name: str) -> None:
    spec = home_spec(name)
    assert problems(spec) == []
    assert 4 <= len({r.name.removesuffix("_b") for r in spec.rooms}) <= 15


@pytest.mark.parametrize("scene", SCENES)
def test_every_edge_of_the_program_is_an_opening(scene: str) -> None:
    spec, program = home_spec(scene), scene_programs()[scene]
    names = [r.name.removesuffix("_b") for r in spec.rooms]
    joined = {frozenset((names[o.room_a], names[o.room_b])) for o in spec.openings}
    assert {frozenset((a, b)) for a, b, _ in program.edges} <= joined
    assert {r.name for r in program.rooms} == set(names)


@pytest.mark.parametrize("scene", SCENES)
def test_doorways_have_a_frame_with_a_free_middle(scene: str) -> None:
    spec = home_spec(scene)
    doorways = sum(joint == "doorway" for *_, joint in scene_programs()[scene].edges)
    frames = [i for i in spec.items if i.category == "door"]
    assert len(frames) == doorways > 0
    free, _ = nav_grid(spec)
    low = np.array([r.rect for r in spec.rooms])[:, :2].min(0)
    for frame in frames:
        along = 1 - frame.quarter_turns % 2
        middle = np.array(frame.position[:2])
        side = np.array([0.125, 0.125])
        passable = 0
        for shift in (-0.125, 0.125):
            both = []
            for across in (-0.125, 0.125):
                at = middle.copy()
                at[along] += shift
                at[1 - along] += across
                i, j = ((at - low) / GRID_M).astype(int)
                both.append(bool(free[i, j]))
            passable += all(both)
        assert passable == 2, f"{frame.position} {side}"


def test_hash_is_the_same_in_another_process() -> None:
    names = ["Rs_int", "house_double_floor_lower", "Merom_1_int~2", "procedural:house:3", "procedural:shop:1"]
    code = f"import json; from ucon.scenes import home_spec; print(json.dumps([home_spec(n).hash for n in {names!r}]))"
    for hashseed in ("1", "77"):
        out = subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            env={"PYTHONHASHSEED": hashseed, "PATH": "/usr/bin:/bin"},
            cwd=Path(__file__).resolve().parents[2],
        ).stdout
        assert json.loads(out) == [home_spec(n).hash for n in names]


def test_seeds_give_different_homes() -> None:
    hashes = {home_spec(name).hash for name in procedural(10)}
    assert len(hashes) == 50


#: The largest scene takes .7 to 1.1 s on a processor without AVX-512.
BY_SIZE = [pytest.param(scene, marks=where_it_was_set) if scene == "house_single_floor" else scene for scene in SCENES]


@pytest.mark.parametrize("scene", BY_SIZE)
@pytest.mark.timed
def test_specification_is_quick(scene: str) -> None:
    def build() -> None:
        built_home.cache_clear()
        built_home(scene)

    build()  # compiled kernels and models are shared by all homes
    assert fastest_s(build, 2) < 1.0


@pytest.mark.parametrize("scene", SCENES)
def test_furniture_of_the_program_stands(scene: str) -> None:
    """No category in the program's furniture is missing entirely, and few items are left out."""
    built = built_home(scene)
    have = Counter(item.category for item in built.spec.items)
    wanted = Counter({c: n for r in scene_programs()[scene].rooms for c, n in r.furniture.items()})
    missing = sorted(c for c in wanted if have[c] == 0)
    assert missing == []
    dropped = sum(sum(rooms.values()) for rooms in built.dropped.values())
    assert dropped <= 0.15 * len(built.spec.items)


@pytest.mark.skipif(not FACTS.is_file(), reason="measured inventories are not beside this checkout")
@pytest.mark.parametrize("scene", SCENES)
def test_measured_fixed_anchors_exist(scene: str) -> None:
    facts = json.loads(FACTS.read_text())["scenes"][scene]["anchors"]
    catalogue = json.loads(FACTS.with_name("categories.json").read_text())["categories"]
    structural = {"walls", "floors", "ceilings", "roof", "lawn", "driveway", "pillar", "structural_element", "railing"}
    odd = {"stand", "skeletal_frame", "greenery", "folderal", "dress", "spotlight"}
    odd |= {"swing", "rail_fence"} if scene == "grocery_store_cafe" else set()  # gates, which need no counterpart here
    anchors = {
        name
        for name, row in facts.items()
        if row["in_base"]
        and name not in structural | odd
        and catalogue[name]["role"] in ("fixed", "fixed_furniture", "movable_furniture")
    }
    have = {item.category for item in home_spec(scene).items}
    assert sorted(anchors - have) == []


@pytest.mark.parametrize("scene", SCENES)
def test_longest_walk(scene: str) -> None:
    """The longest shortest path stays near what 300 steps can cover."""
    free, _ = nav_grid(home_spec(scene))
    start = tuple(np.argwhere(free)[0])
    far, _ = _farthest(free, start)
    _, steps = _farthest(free, far)
    area = sum((r.rect[2] - r.rect[0]) * (r.rect[3] - r.rect[1]) for r in home_spec(scene).rooms)
    assert steps * GRID_M <= 15.0 + 2.2 * area**0.5


def _farthest(free: np.ndarray, start: tuple[int, ...]) -> tuple[tuple[int, ...], int]:
    seen = np.zeros_like(free)
    seen[start] = True
    front, steps, last = [start], 0, start
    while front:
        following = []
        for i, j in front:
            for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                if 0 <= a < free.shape[0] and 0 <= b < free.shape[1] and free[a, b] and not seen[a, b]:
                    seen[a, b] = True
                    following.append((a, b))
        if following:
            steps, last = steps + 1, following[0]
        front = following
    return last, steps


@pytest.mark.parametrize("scene", ["Rs_int", "Wainscott_0_int", "Merom_1_int", "Beechwood_1_int"])
def test_kitchen_and_bedroom_make_sense(scene: str) -> None:
    spec = home_spec(scene)
    for item in spec.items:
        room = spec.rooms[item.room]
        if item.category == "bed":
            box, turn = box_of(item), item.quarter_turns
            back = (box[0] - room.rect[0], box[1] - room.rect[1], room.rect[2] - box[3], room.rect[3] - box[4])[turn]
            assert back < 0.15, "the head of a bed is at a wall"
        if item.category == "range_hood":
            below = [i for i in spec.items if i.category in ("stove", "oven") and i.room == item.room]
            assert any(abs(item.position[k] - i.position[k]) < 0.3 for i in below for k in (0, 1))


@pytest.mark.parametrize("scene", SCENES)
def test_small_things_rest_on_something(scene: str) -> None:
    """Everything not on the floor, a wall or the ceiling has a surface right below it."""
    spec = home_spec(scene)
    for index, item in enumerate(spec.items):
        z = item.position[2]
        if z < 0.01 or build_model(item.category, item.size).mass_kg <= 0:
            continue
        mount = _mount(item.category)
        if mount in ("wall", "ceiling") or item.category in ("countertop", "wall_mounted_tv"):
            continue
        assert any(
            abs(other.position[2] + surface - z) < 0.01 and overlap(_grown(box_of(item)), _grown(box_of(other))) > 0
            for n, other in enumerate(spec.items)
            if n != index and other.room == item.room
            for surface in [*(s.z for s in build_model(other.category, other.size).surfaces), other.size[2]]
        ), f"{item.category} at {item.position}"


def _mount(category: str) -> str:
    from ucon.objects.catalogue import catalogue

    return catalogue()[category].mount


def _grown(box: np.ndarray) -> np.ndarray:
    return box + np.array([-0.01, -0.01, -0.01, 0.01, 0.01, 0.01])


def test_audit_finds_faults() -> None:
    """The audit must object to a home with a shelf in a doorway, and to one with two shelves in one place."""
    from dataclasses import replace

    spec = home_spec("Rs_int")
    door = next(i for i in spec.items if i.category == "door")
    shelf = next(i for i in spec.items if i.category == "shelf")
    blocked = replace(spec, items=(*spec.items, replace(shelf, position=door.position, size=(1.2, 1.2, 2.0))))
    assert walk_problems(blocked)
    twin = replace(spec, items=(*spec.items, replace(shelf, tint=shelf.tint + 1)))
    assert any("shelf in shelf" in p for p in problems(twin))


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("Rs_in", "Rs_int"),
        ("Rs_int~", "variant"),
        ("Rs_int~0", "variant"),
        ("Rs_int~x", "variant"),
        ("procedural:house", "procedural:<kind>:<seed>"),
        ("procedural:hous:3", "house"),
        ("procedural:house:-1", "seed"),
        ("procedural:house:1e3", "seed"),
        ("", "unknown scene"),
    ],
)
def test_unknown_names_are_one_clear_line(name: str, hint: str) -> None:
    with pytest.raises(UconError) as error:
        home_spec(name)
    text = str(error.value)
    assert hint in text
    assert "\n" not in text


@pytest.mark.parametrize("name", ["Rs_int", "house_double_floor_lower", "procedural:office:2"])
def test_plan_is_a_picture(name: str) -> None:
    spec: HomeSpec = home_spec(name)
    image = draw_plan(spec, 20)
    assert image.dtype == np.uint8
    assert image.ndim == 3
    assert image.shape[2] == 3
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20
