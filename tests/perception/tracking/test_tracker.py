from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors import Frame
from ucon.perception.detectors.boxes import Boxes, overlap
from ucon.perception.detectors.noise_rates import EXACT
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.mapping import map_kernels
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.tracking.owners import TrackInstances
from ucon.perception.tracking.tracker import STRUCTURE, Tracker

PX = 128


def room(pose: tuple[float, float, float, float], things: list[np.ndarray]) -> tuple[Frame, np.ndarray]:
    """A frame of boxes (6,) in a room of 10 x 10 x 2.5 m around (2, 0), and the box number of every pixel."""
    x, y, yaw, pitch = pose
    v, u = np.mgrid[:PX, :PX]
    right, up = (u + 0.5 - 64) / 64, (63.5 - v) / 64
    ahead, rise = np.cos(pitch) - np.sin(pitch) * up, np.sin(pitch) + np.cos(pitch) * up
    ray = np.stack([np.cos(yaw) * ahead + np.sin(yaw) * right, np.sin(yaw) * ahead - np.cos(yaw) * right, rise], -1)
    eye = np.array([x, y, 1.25])
    ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
    walls = np.array([-2.925, -4.925, 0.0, 6.925, 4.925, 2.5])
    depth = np.maximum((walls[:3] - eye) / ray, (walls[3:] - eye) / ray).min(-1)
    owner = np.full((PX, PX), -1)
    for k, box in enumerate(things):
        a, b = (box[:3] - eye) / ray, (box[3:] - eye) / ray
        near, far = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
        hit = (near < far) & (near > 0) & (near < depth)
        depth[hit], owner[hit] = near[hit], k
    shown = Frame(
        depth.astype(np.float32), None, np.array(pose, np.float32), 1.25, 90.0, owner.astype(np.int16),
        np.bincount(owner[owner >= 0], minlength=len(things)).astype(np.int32),
    )  # fmt: skip
    return shown, owner


def boxes_of(owner: np.ndarray, names: list[str]) -> Boxes:
    label, xyxy = [], []
    for k, name in enumerate(names):
        v, u = np.nonzero(owner == k)
        if len(v):
            label.append(name)
            xyxy.append([u.min(), v.min(), u.max() + 1, v.max() + 1])
    return Boxes(label, np.full(len(label), 0.5, np.float32), np.array(xyxy, np.float32).reshape(-1, 4))


def thing(x: float, y: float, size: float = 0.4, z: float = 0.0) -> np.ndarray:
    return np.array([x - size / 2, y - size / 2, z, x + size / 2, y + size / 2, z + size])


ROUND = [
    (0, 0, 0, 0),
    (0, 0.5, 0, 0),
    (1, -1, 0, 0),
    (2.5, -2.5, np.pi / 2, 0),
    (5, 0, np.pi, 0),
    (1.25, 0, 0, -np.pi / 6),
]


def test_one_thing_seen_from_all_sides_stays_one_track() -> None:
    tracker = Tracker()
    for pose in ROUND:
        frame, owner = room(pose, [thing(2.5, 0.0)])
        found = tracker.follow(boxes_of(owner, ["stool"]), frame)
        assert found.track[-1] == 4, pose
        assert found.category[-1] == "stool"
        mine = found.image == 4
        own = (owner == 0) & (heights(frame) > 0.06)  # lower points count as floor
        assert (mine & own).sum() > 0.95 * own.sum(), "what is the thing's is given to it"
        assert (mine & (owner < 0)).sum() < 0.25 * (owner == 0).sum(), "and little else"


def test_two_of_a_kind_a_metre_apart_are_two() -> None:
    tracker = Tracker()
    things = [thing(2.5, -0.5), thing(2.5, 0.5)]
    kept = []
    for pose in ROUND[:3]:
        frame, owner = room(pose, things)
        found = tracker.follow(boxes_of(owner, ["stool", "stool"]), frame)
        assert found.track[-2:].tolist() == [4, 5]
        kept.append([int(np.bincount(owner[found.image == track] + 1).argmax()) - 1 for track in (4, 5)])
    assert kept[0] == kept[1] == kept[2], "each number stays with its thing"
    assert sorted(kept[0]) == [0, 1]


def test_one_thing_of_two_names_is_one_track_and_each_track_takes_one_box() -> None:
    tracker = Tracker()
    frame, owner = room(ROUND[0], [thing(2.5, 0.0)])
    assert tracker.follow(boxes_of(owner, ["stool"]), frame).track[-1] == 4
    found = tracker.follow(boxes_of(owner, ["table"]), frame)
    assert (found.track[-1], found.category[-1]) == (4, "table"), "by the name of this frame"
    box = boxes_of(owner, ["stool"])
    double = Boxes(["stool", "stool"], np.array([0.9, 0.4], np.float32), np.tile(box.xyxy, (2, 1)))
    found = tracker.follow(double, frame)
    assert found.track[-2:].tolist() == [4, 5]
    tracker.reset()
    assert tracker.follow(box, frame).track[-1] == 4


def test_smaller_boxes_lie_over_larger_ones() -> None:
    things = [thing(2.5, 0.0, 0.8), thing(2.4, 0.0, 0.2, z=0.8)]
    frame, owner = room((1.0, 0, 0, -np.pi / 6), things)
    table = boxes_of(owner, ["table", "mug"])
    table.xyxy[0, 1] = min(table.xyxy[0, 1], table.xyxy[1, 1])
    found = Tracker().follow(table, frame)
    assert found.category[-2:] == ("table", "mug")
    assert (found.image[owner == 1] == 5).mean() > 0.95
    assert (found.image[owner == 0] == 4).mean() > 0.8
    assert found.pixels[-2] > (found.image == 4).sum(), "pixels count what the smaller one hides"


def test_masks_are_taken_as_they_are() -> None:
    frame, owner = room(ROUND[0], [thing(2.5, 0.0)])
    box = boxes_of(owner, ["stool"])
    masked = Boxes(box.label, box.score, box.xyxy, (owner == 0)[None])
    assert ((Tracker().follow(masked, frame).image == 4) == (owner == 0)).all()


def test_what_no_box_holds_is_told_by_geometry() -> None:
    stool = [thing(2.5, 0.0)]
    frame, owner = room((0, 0, 0, 0), stool)
    found = Tracker().follow(Boxes.none(), frame)
    assert set(found.category) == set(STRUCTURE)
    assert (found.image[1::2] == -1).all(), "every second row and column is classified"
    assert (found.image[:, 1::2] == -1).all()
    found_image, owner = found.image[::2, ::2], owner[::2, ::2]
    name, z = np.array(STRUCTURE)[found_image], heights(frame)[::2, ::2]
    assert (name[(owner == 0) & (z > 0.06)] == "obstacles").mean() > 0.9, "no thing, and no wall either"
    assert (name[(z < 0.04) & (owner < 0)] == "floors").all()
    assert (name[z > 2.3] == "ceilings").all()
    wall = (owner < 0) & (z > 0.1) & (z < 2.1)
    assert (name[wall] == "walls").mean() > 0.9


def heights(frame: Frame) -> np.ndarray:
    v = np.arange(PX)[:, None]
    up, pitch = (63.5 - v) / 64, float(frame.pose[3])
    return 1.25 + frame.depth * (np.sin(pitch) + np.cos(pitch) * up)


def test_the_map_knows_obstacles_and_room_without_any_detection() -> None:
    tracker, known, truth = Tracker(), SemanticMap(), SemanticMap()
    for pose in ROUND[:3]:
        frame, owner = room(pose, [thing(2.5, 0.0)])
        observation = {"depth": frame.depth, "pose": frame.pose, "collision": np.zeros(1, np.int8)}
        found = tracker.follow(Boxes.none(), frame)
        known.update(observation, {"detections": replace(found, score=None), "tracks": found.image})
        found = tracker_of_truth(frame, owner)
        truth.update(observation, found)
    i, j = round(2.5 / 0.25) + 128, 128
    assert known.blocked[i, j]
    assert known.height[i, j] > 0.3
    assert not known.walls[:, i - 1 : i + 2, j - 1 : j + 2].any(), "a stool is no wall"
    assert known.walls.any(), "walls are"
    assert (known.explored == truth.explored).all()
    assert (known.floor == truth.floor).all()
    assert (known.blocked == truth.blocked).all()
    assert not any(known.seen(track) for track in range(known.n_tracks)), "structure has no box"


def tracker_of_truth(frame: Frame, owner: np.ndarray) -> dict:
    image = np.where(owner >= 0, 1, 0).astype(np.int16)
    found = {"track": [0, 1], "category": ["walls", "stool"], "pixels": np.bincount(image.ravel(), minlength=2)}
    return {"detections": found, "tracks": image}


def test_obstacles_are_a_kind_of_their_own() -> None:
    kinds = {map_kernels.FLOORS, map_kernels.WALLS, map_kernels.CEILINGS}
    from ucon.perception.mapping.detections import STRUCTURE_KINDS

    assert tuple(STRUCTURE_KINDS) == STRUCTURE
    assert STRUCTURE_KINDS["obstacles"] not in kinds | {0}


def test_maps_of_a_home_agree_on_what_blocks() -> None:
    """With exact boxes, the cells where an agent can stand are nearly those of the truth."""
    maps = []
    for detector in (True, NoisyDetector(EXACT)):
        env = UcONEnv("mini", observe="symbolic", detector=detector, habit_level="none")
        obs, info = env.reset(options={"episode": 0})
        known = SemanticMap.of(info)
        for action in (1, 1, 1, 1, 4, 1, 1, 1, 1, 3, 0, 0, 1, 0, 0):
            known.update(obs, info)
            obs, _, _, _, info = env.step(action)
        maps.append(known)
        env.close()
    a, b = maps
    assert (a.explored == b.explored).all()
    assert (a.blocked != b.blocked).sum() < 0.03 * (a.explored > 0).sum()
    assert (a.walls & b.walls).sum() > 0.5 * a.walls.sum()
    assert (b.walls & ~a.walls & 1).sum() < 0.1 * a.walls.sum()


def test_opened_tracks_are_those_whose_pixels_lie_on_what_was_opened() -> None:
    frame, owner = room(ROUND[0], [thing(2.5, -0.5), thing(2.5, 0.5)])
    tracker, owners = Tracker(), TrackInstances()
    names = ["fridge", "fridge"]
    found = tracker.follow(boxes_of(owner, names), frame)
    owners.note(found, frame, len(STRUCTURE))
    first = int(np.bincount(found.image[owner == 0][found.image[owner == 0] >= 4]).argmax())
    assert owners.of((0,)) == (first,)
    assert owners.of((1,)) == (9 - first,)
    assert owners.of((0, 1)) == (4, 5)
    assert owners.of(()) == ()
    away, hidden = room((0, 0, np.pi, 0), [thing(2.5, -0.5), thing(2.5, 0.5)])
    owners.note(tracker.follow(boxes_of(hidden, names), away), away, len(STRUCTURE))
    assert owners.of((0,)) == (first,), "the last frame that showed it counts"


def test_exact_boxes_tell_which_container_an_agent_opened() -> None:
    env = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(EXACT), habit_level="none")
    opened = 0
    for number in range(12):
        env.reset(options={"episode": number})
        for digit in env.episode.solution:
            before = env.search.opened.copy()
            info = env.step(int(digit))[4]
            fresh = np.flatnonzero(env.search.opened & ~before)
            categories = {env.search.world.categories[k] for k in fresh}
            names = dict(zip(info["detections"].track.tolist(), info["detections"].category, strict=True))
            for track in info["opened"]:
                assert names.get(track, next(iter(categories))) in categories
                opened += 1
            assert len(fresh) or not info["opened"]
    assert opened >= 2
    env.close()


def test_doubles_of_one_name_are_one_and_others_stay() -> None:
    xyxy = np.array([[0, 0, 10, 10], [1, 0, 11, 10], [0, 0, 10, 10], [30, 30, 40, 40]], np.float32)
    boxes = Boxes(["mug", "mug", "cup", "mug"], np.array([0.5, 0.9, 0.4, 0.3], np.float32), xyxy)
    kept = boxes.non_maximum_suppression(0.5, 10)
    assert kept.label == ["mug", "cup", "mug"]
    assert kept.score.tolist() == pytest.approx([0.9, 0.4, 0.3])
    assert boxes.non_maximum_suppression(0.5, 2).label == ["mug", "cup"]
    assert overlap(xyxy[0], xyxy).tolist() == pytest.approx([1.0, 9 / 11, 1.0, 0.0])
