"""Room programs: the package's data, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ucon.core.errors import DataError
from ucon.objects.catalogue import catalogue
from ucon.scenes.layout import block_plan
from ucon.scenes.procedural import procedural_program
from ucon.scenes.program import HOME_KINDS, HomeProgram, check_program, scene_programs, type_stats
from ucon.scenes.tidy import shared_wall


@pytest.mark.parametrize("scene", list(scene_programs()))
def test_categories_are_in_the_catalogue(scene: str) -> None:
    names = {c for r in scene_programs()[scene].rooms for m in (r.furniture, r.surface, r.fixtures) for c in m}
    assert sorted(n for n in names if n not in catalogue()) == []


def test_statistics_cover_homes() -> None:
    assert {"bathroom", "bedroom", "kitchen", "living_room", "corridor"} <= set(type_stats())


@pytest.mark.parametrize("kind", HOME_KINDS)
@pytest.mark.parametrize("seed", range(40))
def test_generated_programs_are_valid(kind: str, seed: int) -> None:
    program = procedural_program(kind, seed)
    check_program(f"{kind}:{seed}", program)
    names = {c for r in program.rooms for m in (r.furniture, r.surface, r.fixtures) for c in m}
    assert sorted(n for n in names if n not in catalogue()) == []


def _broken() -> list[tuple[str, HomeProgram]]:
    good = scene_programs()["Rs_int"]
    return [
        ("kind", replace(good, kind="castle")),
        ("joint", replace(good, edges=((*good.edges[0][:2], "portcullis"), *good.edges[1:]))),
        ("edges", replace(good, edges=good.edges[1:])),
        ("share a name", replace(good, rooms=(*good.rooms, good.rooms[0]))),
        ("side", replace(good, rooms=(replace(good.rooms[0], size_m=(0.0, 3.0)), *good.rooms[1:]))),
        ("count", replace(good, rooms=(replace(good.rooms[0], furniture={"bed": 0}), *good.rooms[1:]))),
    ]


@pytest.mark.parametrize(("word", "program"), _broken())
def test_broken_programs_are_refused(word: str, program: HomeProgram) -> None:
    with pytest.raises(DataError, match=word):
        check_program("test", program)


@pytest.mark.parametrize("scene", list(scene_programs()))
def test_the_plain_plan_always_exists(scene: str) -> None:
    plan = block_plan(scene_programs()[scene])
    for a, b, _ in plan.edges:
        wall = shared_wall(plan.rect(a), plan.rect(b))
        assert wall is not None
        assert wall[3] - wall[2] >= 6
    for i, a in enumerate(plan.rects):
        for b in plan.rects[:i]:
            assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] or b[1] >= a[3]
