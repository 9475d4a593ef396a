"""When closed, nothing inside can be seen from anywhere; when open, it can, from where a robot can stand."""

from __future__ import annotations

import numpy as np
import pytest
from rays import Array, cast, pose

from ucon.core.rng import stream
from ucon.objects import build_model, catalogue
from ucon.objects.bounds import part_box
from ucon.objects.model import Compartment, ObjectModel

OPENABLE = tuple(row.name for row in catalogue() if row.openable)
EYE_M = 1.25


def model_at(name: str, width: float) -> ObjectModel:
    x, y, z = catalogue()[name].size
    return build_model(name, (x, round(y * width, 3), z))


def base_height(name: str) -> float:
    """Height of the object's bottom above the floor of the room."""
    return catalogue()[name].bottom_z_m


def points_in(c: Compartment, count: int, seed: int) -> Array:
    low, high = np.array(c.box[:3]), np.array(c.box[3:])
    return low + (high - low) * (0.02 + 0.96 * stream(seed, "points").random((count, 3)))


def blocked(model: ObjectModel, eyes: Array, points: Array, opening: float) -> np.ndarray:
    distance, _, _ = cast(model, eyes, points - eyes, opening)
    return distance < 1.0 - 1e-6


@pytest.mark.parametrize("width", [0.7, 1.0, 1.6])
@pytest.mark.parametrize("name", OPENABLE)
def test_closed_hides_everything(name: str, width: float) -> None:
    model = model_at(name, width)
    random = stream(7, "eyes", name)
    for number, c in enumerate(model.compartments):
        count = 1500
        inside = points_in(c, count, number)
        around = random.normal(size=(count, 3))
        around /= np.linalg.norm(around, axis=1)[:, None]
        eyes = np.array([0, 0, model.size[2] / 2]) + around * (np.linalg.norm(model.size) + random.random((count, 1)))
        eyes[: count // 2, 2] = EYE_M - base_height(name)
        far = np.abs(eyes[:, :2]).max(1) > max(model.size[:2])
        seen = ~blocked(model, eyes, inside, 0.0) & far
        assert not seen.any(), (c, eyes[seen][:2], inside[seen][:2])


@pytest.mark.parametrize("width", [0.8, 1.0, 1.5])
@pytest.mark.parametrize("name", OPENABLE)
def test_open_shows_what_lies_there(name: str, width: float) -> None:
    """A 6 cm cube on a compartment's floor can be seen from some standing place, nearly wherever it lies."""
    model = model_at(name, width)
    heights = [base_height(name)]
    if catalogue()[name].mount == "surface":
        heights = [0.0, 0.75]
    for number, c in enumerate(model.compartments):
        span = np.array(c.box[3:]) - np.array(c.box[:3])
        assert span.min() > 0.02
        half = np.minimum(0.03, span / 2 - 0.002)
        spots = stream(number, "spots", name).random((40, 2))
        low, high = np.array(c.box[:2]) + half[:2], np.array(c.box[3:5]) - half[:2]
        xy = low + spots * (high - low)
        fraction = max(visible_share(model, c, xy, half, height) for height in heights)
        assert fraction >= 0.9, (c, fraction)


def visible_share(model: ObjectModel, c: Compartment, xy: Array, half: Array, height: float) -> float:
    """Share of the spots whose cube is seen from some place at most 1.1 m from it, with the joints open."""
    turn, shift = pose(model, c.link, 1.0)
    x, y, _ = model.size
    seen = 0
    ahead = np.array(
        [(px, py, EYE_M - height) for px in (0.3, 0.45, 0.6, 0.8, 0.95) for py in (-0.6, -0.3, 0.0, 0.3, 0.6)]
    )
    lidded = any(
        joint.kind == "revolute" and not joint.axis[2] and joint.origin[2] > 0.5 * model.size[2]
        for joint in model.joints
    )
    for spot in xy:
        marks = np.array([(sx, sy, sz) for sx in (0.9, 0.0) for sy in (-0.8, 0.0, 0.8) for sz in (1.0, 1.96)])
        cube = np.array([*spot, c.box[2]]) + marks * [half[0], half[1], half[2]]
        cube = cube @ turn.T + shift
        eyes = ahead + np.array([x / 2, cube[0, 1], 0.0])
        if lidded:  # One can walk around it.
            left = ahead[:, [1, 0, 2]] + [cube[0, 0], y / 2, 0.0]
            right = ahead[:, [1, 0, 2]] * [1, -1, 1] + [cube[0, 0], -y / 2, 0.0]
            eyes = np.vstack([eyes, left, right])
        near = np.hypot(*(eyes[:, :2] - cube[0, :2]).T) < 1.1
        pairs = [(e, p) for e in eyes[near] for p in cube]
        if pairs:
            a, b = (np.array(side) for side in zip(*pairs, strict=True))
            seen += bool((~blocked(model, a, b, 1.0)).sum() >= 2)
    return seen / len(xy)


@pytest.mark.parametrize("name", OPENABLE)
def test_leaves_stay_in_front_of_their_own_unit(name: str) -> None:
    """Neighbours are not hit: what a joint carries leaves the width of the unit by less than 5 mm."""
    model = build_model(name)
    y = model.size[1]
    if any(joint.axis[0] for joint in model.joints if joint.kind == "revolute"):
        pytest.skip("flaps turn to the sides on purpose")
    for opening in (0.25, 0.5, 0.75, 1.0):
        for part in model.parts:
            if part.link < 0:
                continue
            turn, shift = pose(model, part.link, opening)
            signs = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) / 2
            if part.shape == "cylinder":  # Only discs across x are carried.
                angles = np.arange(24) * np.pi / 12
                signs = np.stack([np.zeros(24), np.cos(angles) / 2, np.sin(angles) / 2], 1)
            extent = np.array(part_box(part)[3:]) - np.array(part_box(part)[:3])
            corners = (np.array(part.center) + signs * extent) @ turn.T + shift
            assert np.abs(corners[:, 1]).max() <= y / 2 + 0.005, (part, opening)
            assert corners[:, 0].min() >= -model.size[0] / 2 - 0.005
