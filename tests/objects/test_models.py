"""Every category builds into something that fills its size, with places that are really free."""

from __future__ import annotations

import time

import numpy as np
import pytest
from rays import planes

from ucon.core.errors import ConfigError
from ucon.core.geometry import matrix_from_rpy
from ucon.objects import build_model, catalogue
from ucon.objects.bounds import part_box, union_box
from ucon.objects.kit import SHAPES
from ucon.objects.model import Box3, ObjectModel

NAMES = catalogue().names
SLACK = 1e-3
MOST_PARTS = 17
MOST_PARTS_OPENABLE = 24
"""A chest of three drawers needs five parts per drawer, five panels, two rails, plinth and top."""


def overlap(a: Box3, b: Box3) -> float:
    """Depth in metres by which two boxes interpenetrate; 0 or less when they do not."""
    return min(min(a[i + 3], b[i + 3]) - max(a[i], b[i]) for i in range(3))


def blocking(model: ObjectModel, space: Box3) -> list[tuple[str, float]]:
    """Parts whose interior reaches into ``space``; all but upright boxes are tested by points."""
    found = []
    low, high = np.array(space[:3]), np.array(space[3:])
    grid = np.stack(np.meshgrid(*[np.linspace(0.04, 0.96, 7)] * 3), -1).reshape(-1, 3)
    points = low + grid * (high - low)
    for part in model.parts:
        depth = overlap(part_box(part), space)
        if depth <= SLACK:
            continue
        if part.shape == "box" and part.rpy_rad == (0.0, 0.0, 0.0):
            found.append((str(part), depth))
            continue
        normals, offsets = planes(part)
        local = (points - np.array(part.center)) @ matrix_from_rpy(part.rpy_rad)
        if ((local @ normals.T) <= offsets - SLACK).all(1).any():
            found.append((str(part), depth))
    return found


@pytest.mark.parametrize("name", NAMES)
def test_shape(name: str) -> None:
    model, row = build_model(name), catalogue()[name]
    assert model.category == name
    assert model.size == row.size
    assert 1 <= len(model.parts) <= (MOST_PARTS_OPENABLE if model.joints else MOST_PARTS), len(model.parts)
    for part in model.parts:
        figures = [*part.size, *part.center, *part.rpy_rad, part.taper]
        assert np.isfinite(figures).all()
        assert min(part.size) > 1e-5
        assert 0.0 <= part.taper <= 1.0
        assert all(isinstance(c, int) and 0 <= c <= 255 for c in part.color)
        assert -1 <= part.link < len(model.joints)
    x, y, z = model.size
    box = union_box(map(part_box, model.parts))
    wanted = (-x / 2, -y / 2, 0.0, x / 2, y / 2, z)
    for got, want, sign in zip(box, wanted, (-1, -1, -1, 1, 1, 1), strict=True):
        assert sign * (got - want) <= SLACK, f"sticks out: {box} of {wanted}"
        assert sign * (want - got) <= max(0.06 * max(x, y, z), 0.012), f"does not fill: {box} of {wanted}"


@pytest.mark.parametrize("name", NAMES)
def test_meaning(name: str) -> None:
    """A category's model does what the catalogue says."""
    model, row = build_model(name), catalogue()[name]
    assert model.openable == row.openable
    assert bool(model.compartments) == row.container
    assert bool(model.surfaces) == row.support
    assert model.mass_kg == row.mass_kg
    for joint in model.joints:
        assert joint.travel > 0
        assert np.linalg.norm(joint.axis) == pytest.approx(1.0)
    if row.openable:
        assert {j for c in model.compartments for j in c.opened_by} == set(range(len(model.joints)))


@pytest.mark.parametrize("name", NAMES)
def test_places(name: str) -> None:
    """Surfaces are clear, compartments and spaces below are empty, and all are within the object's footprint."""
    model = build_model(name)
    x, y, z = model.size
    for s in model.surfaces:
        assert -x / 2 - SLACK <= s.x0 < s.x1 <= x / 2 + SLACK
        assert -y / 2 - SLACK <= s.y0 < s.y1 <= y / 2 + SLACK
        assert 0.0 <= s.z <= z + SLACK
        room: Box3 = (s.x0, s.y0, s.z + 0.005, s.x1, s.y1, s.z + min(s.clearance_m, 0.25))
        assert s.clearance_m >= 0.15
        assert not blocking(model, room), (s, blocking(model, room))
        below: Box3 = (s.x0, s.y0, s.z - 0.004, s.x1, s.y1, s.z + 0.004)
        assert any(overlap(part_box(part), below) > 0.0 for part in model.parts), f"nothing carries {s}"
    for c in model.compartments:
        assert c.box[0] < c.box[3]
        assert c.box[1] < c.box[4]
        assert c.box[2] < c.box[5]
        assert not blocking(model, c.box), (c, blocking(model, c.box))
        assert -1 <= c.link < len(model.joints)
    for u in model.under:
        assert min(u[3] - u[0], u[4] - u[1], u[5] - u[2]) > 0.03
        assert not blocking(model, u), (u, blocking(model, u))


def test_every_archetype_has_a_builder() -> None:
    assert {row.archetype for row in catalogue() if row.name not in SHAPES} <= set(SHAPES)


@pytest.mark.parametrize(
    "name", ["bottom_cabinet", "countertop", "top_cabinet", "fridge", "sofa", "bed", "shelf", "desk", "carpet", "sink"]
)
@pytest.mark.parametrize("scale", [(1.0, 0.7, 1.0), (1.0, 1.6, 1.0), (0.9, 1.0, 1.15)])
def test_other_sizes(name: str, scale: tuple[float, float, float]) -> None:
    size = tuple(round(s * f, 3) for s, f in zip(catalogue()[name].size, scale, strict=True))
    model = build_model(name, size)
    assert model.size == size
    box = union_box(map(part_box, model.parts))
    for low, high, extent in zip(box[:3], box[3:], size, strict=True):
        assert extent - 0.05 < high - low <= extent + 2 * SLACK
    for c in model.compartments:
        assert not blocking(model, c.box)


def test_same_call_same_model() -> None:
    first = {name: repr(build_model(name, None, 3)) for name in NAMES}
    build_model.cache_clear()
    assert first == {name: repr(build_model(name, None, 3)) for name in NAMES}


def test_tint_changes_colour_only() -> None:
    plain, tinted = build_model("sofa"), build_model("sofa", None, 5)
    assert [p.color for p in plain.parts] != [p.color for p in tinted.parts]
    assert [(p.size, p.center) for p in plain.parts] == [(p.size, p.center) for p in tinted.parts]
    assert len({build_model("sofa", None, tint).parts[0].color for tint in range(8)}) >= 4


def test_bad_requests() -> None:
    with pytest.raises(ConfigError, match="did you mean coffee_table"):
        build_model("coffee_tabel")
    with pytest.raises(ConfigError, match="three lengths"):
        build_model("bed", (1.0, 2.0, 0.0))


@pytest.mark.timed
def test_building_is_quick() -> None:
    build_model.cache_clear()
    start = time.process_time()
    for name in NAMES:
        build_model(name)
    assert (time.process_time() - start) / len(NAMES) < 2e-3
