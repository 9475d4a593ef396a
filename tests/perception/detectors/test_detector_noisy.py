from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from models.agents.belief import BeliefAgent
from models.agents.frontier import FrontierAgent
from tests.models.playing import config_of
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors import Frame, vocabulary
from ucon.perception.detectors.confusion import confusion, wrong_name
from ucon.perception.detectors.noise_rates import EXACT, Rates
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.mapping.detections import STRUCTURE_KINDS

WALK = (1, 1, 1, 1, 0, 0, 3, 2, 4, 0, 0, 2, 0, 0, 4, 1, 1, 3, 0, 0, 5, 1, 0, 0)


class Watching(NoisyDetector):
    """A detector that keeps the last frame."""

    def find(self, frame: Frame):
        self.frame = Frame(frame.depth, None, frame.pose, frame.camera_m, 90.0, frame.instance.copy(), frame.counts)
        return super().find(frame)


@pytest.fixture(scope="module")
def frames() -> list[tuple[str, tuple[str, ...], Frame]]:
    """Episode, categories and frame of about 600 looks in 12 homes."""
    detector = Watching(EXACT)
    env = UcONEnv("mini", observe="symbolic", detector=detector, habit_level="none")
    found = []
    for number in range(12):
        env.reset(options={"episode": number})
        for action in 2 * WALK:
            found.append((env.episode.id, env.search.world.categories, detector.frame))
            env.step(action)
    env.close()
    return found


def boxes_of(detector: NoisyDetector, frames: list) -> Iterator[tuple]:
    last = None
    for episode, categories, frame in frames:
        if episode != last:
            detector.reset(episode, categories)
            last = episode
        yield categories, frame, detector.find(frame)


def in_view(categories: tuple[str, ...], frame: Frame) -> list[int]:
    return [k for k in np.flatnonzero(frame.counts >= 4) if categories[k] not in STRUCTURE_KINDS]


def test_misses_come_out_as_set_for_every_size(frames: list) -> None:
    sizes = dataclasses.replace(EXACT, recall=(0.3, 0.9), recall_px=(10, 1000))
    chance = lambda px: float(np.interp(np.log(px), np.log((10, 1000)), (0.3, 0.9)))  # noqa: E731
    found, expected = np.zeros(3), np.zeros(3)
    looks = (look for seed in range(16) for look in boxes_of(NoisyDetector(sizes, seed=seed), frames))
    for categories, frame, boxes in looks:
        there, seen = in_view(categories, frame), Counter(boxes.label)
        alone = Counter(categories[k] for k in there)
        for k in there:
            if alone[categories[k]] > 1:
                continue  # with several of a name, the missed one is unknown
            row = int(np.digitize(frame.counts[k], (30, 300)))
            found[row] += seen[categories[k]]
            expected[row] += chance(frame.counts[k])
    assert expected.min() > 60
    np.testing.assert_allclose(found / expected, 1.0, atol=0.1)


def test_wrong_names_come_out_as_set(frames: list) -> None:
    rates = dataclasses.replace(EXACT, false_labels=0.25)
    wrong = []
    for categories, frame, boxes in boxes_of(NoisyDetector(rates), frames):
        truth = [categories[k] for k in in_view(categories, frame)]
        assert len(boxes.label) == len(truth)
        wrong += [given != name for given, name in zip(boxes.label, truth, strict=True)]
        assert set(boxes.label) <= set(vocabulary())
    assert len(wrong) > 2000
    assert np.mean(wrong) == pytest.approx(0.25, abs=0.03)


def test_false_boxes_come_out_as_set(frames: list) -> None:
    rates = dataclasses.replace(EXACT, recall=(0.0,), false_positives=0.6)
    n = [len(boxes.label) for _, _, boxes in boxes_of(NoisyDetector(rates), frames)]
    # One spot may be seen in many frames, so the spread is larger than for independent draws.
    assert np.mean(n) == pytest.approx(0.6, abs=0.15)


def _scores(rates: Rates, frames: list) -> dict[bool, list[tuple[float, float]]]:
    """Scores of boxes and metres to their centres, by whether the box is right."""
    scores: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    looks = (
        (detector, look)
        for seed in range(4)
        for detector in [NoisyDetector(rates, seed=seed)]
        for look in boxes_of(detector, frames)
    )
    for detector, (categories, frame, boxes) in looks:
        n = len(detector._things(frame, frame.camera))
        for row, (label, score) in enumerate(zip(boxes.label, boxes.score.tolist(), strict=True)):
            k = int(detector._found[0][row]) if row < n else -1
            away = np.linalg.norm(detector._outlines[1][k] - frame.camera[:3]) if row < n else 0.0
            scores[row < n and label == categories[k]].append((score, float(away)))
    return scores


def _auroc(right: np.ndarray, wrong: np.ndarray) -> float:
    below = np.searchsorted(np.sort(wrong), right, "left") + np.searchsorted(np.sort(wrong), right, "right")
    return float(below.mean() / (2 * len(wrong)))


@pytest.mark.parametrize("auroc", [0.75, 0.8, 0.85])
def test_scores_overlap_as_set_near_and_far(frames: list, auroc: float) -> None:
    rates = dataclasses.replace(Rates(), recall=(0.6,), recall_px=(1.0,), false_labels=0.4, auroc=auroc)
    found = _scores(rates, frames)
    right, wrong = np.array(found[True]), np.array(found[False])
    assert min(right[:, 0].min(), wrong[:, 0].min()) >= 0.25
    assert max(right[:, 0].max(), wrong[:, 0].max()) < 1.0
    assert _auroc(right[:, 0], wrong[:, 0]) == pytest.approx(auroc, abs=0.03)
    things = wrong[wrong[:, 1] > 0]
    for near, far in ((0.0, 2.0), (2.0, 4.0), (4.0, 99.0)):
        a, b = (x[(near <= x[:, 1]) & (x[:, 1] < far), 0] for x in (right, things))
        assert min(len(a), len(b)) > 100
        assert _auroc(a, b) == pytest.approx(auroc, abs=0.06)


@pytest.mark.parametrize("of", ["hidden", "far"])
def test_hidden_and_distant_things_are_found_less_often(frames: list, of: str) -> None:
    half = {
        "hidden": {"hidden": (0.4, 1.0), "hidden_share": (0.3, 0.300001)},
        "far": {"far": (1.0, 0.4), "far_m": (3.0, 3.000001)},
    }
    detector = NoisyDetector(dataclasses.replace(EXACT, **half[of]))
    found: dict[bool, list[bool]] = {True: [], False: []}
    for _categories, frame, _ in boxes_of(detector, frames):
        _, middle, count = detector._outlines
        seen = set(detector._found[0][: len(detector._things(frame, frame.camera))].tolist())
        for k in np.flatnonzero((frame.counts >= 4) & (count > 0) & (detector._surface_m2 > 0)).tolist():
            away = float(np.linalg.norm(middle[k] - frame.camera[:3]))
            whole = min(0.25 * detector._surface_m2[k] * (64 / max(away, 0.1)) ** 2, 4000)
            found[away > 3.0 if of == "far" else frame.counts[k] < 0.3 * whole].append(k in seen)
    assert min(map(len, found.values())) > 300
    assert np.mean(found[False]) == 1.0
    assert np.mean(found[True]) == pytest.approx(0.4, abs=0.06)


def test_three_strengths_are_files(frames: list) -> None:
    looks = []
    for strength in ("noisy_low", "noisy", "noisy_high"):
        detector = Factory(config_of("frontier", f"detector={strength}")["detector"])()
        assert isinstance(detector, NoisyDetector)
        assert detector.name == strength
        right = [
            sum(map(Counter(boxes.label).__contains__, {c[k] for k in in_view(c, f)}))
            for c, f, boxes in boxes_of(detector, frames)
        ]
        looks.append(np.mean(right))
    assert looks[0] > 1.15 * looks[1]
    assert looks[1] > 1.15 * looks[2] > 1.0


def test_boxes_are_off_by_the_jitter(frames: list) -> None:
    exact = boxes_of(NoisyDetector(EXACT), frames)
    shaken = boxes_of(NoisyDetector(dataclasses.replace(EXACT, jitter=0.1)), frames)
    off = []
    for (_, _, a), (_, _, b) in zip(exact, shaken, strict=True):
        side = np.tile(a.xyxy[:, 2:] - a.xyxy[:, :2], 2)
        off.append((b.xyxy - a.xyxy) / side)
    assert np.concatenate(off).std() == pytest.approx(0.1, rel=0.05)
    assert abs(np.concatenate(off).mean()) < 0.01


def test_without_errors_it_says_what_gt_says() -> None:
    envs = [UcONEnv("mini", observe="symbolic", detector=d, habit_level="none") for d in (True, NoisyDetector(EXACT))]
    names = set()
    for number in range(4):
        looks = [env.reset(options={"episode": number})[1] for env in envs]
        for action in WALK:
            truth, found = (Counter(i["detections"].category) for i in looks)
            for name in STRUCTURE_KINDS:
                truth.pop(name, None), found.pop(name, None)
            assert found == truth
            names |= truth.keys()
            looks = [env.step(action)[4] for env in envs]
    assert len(names) > 30
    for env in envs:
        env.close()


def test_the_same_pose_shows_the_same_and_errors_last() -> None:
    env = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="none")
    _, first = env.reset(options={"episode": 1})
    for action in (1, 1, 1):
        env.step(action)
    again = env.step(1)[4]
    assert again["detections"].category == first["detections"].category
    assert (again["tracks"] == first["tracks"]).all()
    env.close()


def play(env: UcONEnv, number: int) -> bytes:
    _, info = env.reset(options={"episode": number})
    parts = []
    for action in WALK:
        found = info["detections"]
        parts += [found.track.tobytes(), found.pixels.tobytes(), found.score.tobytes(), found.image.tobytes()]
        parts.append(repr((found.category, info["opened"])).encode())
        info = env.step(action)[4]
    return b"".join(parts)


def test_an_episode_is_the_same_whatever_was_played_before() -> None:
    used = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="none")
    play(used, 0), play(used, 5)
    fresh = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="none")
    other = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(seed=1), habit_level="none")
    wanted = play(fresh, 3)
    assert play(used, 3) == wanted
    assert play(fresh, 3) == wanted
    assert play(other, 3) != wanted


@pytest.mark.parametrize("make", [FrontierAgent, BeliefAgent])
def test_agents_search_with_it_to_the_end(make: type) -> None:
    env = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="retrieval")
    agent, ends = make(), []
    for number in range(4):
        obs, info = env.reset(options={"episode": number})
        agent.reset([info])
        ended = False
        while not ended:
            obs, _, terminated, truncated, info = env.step(agent.act([obs], [info])[0])
            ended = terminated or truncated
        ends.append(info["episode_metrics"])
    assert all(1 <= end["steps"] <= 300 for end in ends)
    env.close()


def test_errors_do_not_depend_on_the_target() -> None:
    """Wrong names depend on the thing and the catalogue only: any category may come, the target like others."""
    row = confusion("mug")
    assert row.sum() == pytest.approx(1.0)
    names = vocabulary()
    assert row[names.index("mug")] == 0.0
    assert not set(names) & set(STRUCTURE_KINDS)
    likely = [names[k] for k in np.argsort(-row)[:20]]
    volume = lambda name: float(np.prod(catalogue()[name].size))  # noqa: E731
    assert all(0.1 < volume(name) / volume("mug") < 10 for name in likely)
    assert wrong_name("mug", 0.0) in names
    assert wrong_name("mug", 0.999999) in names
    drawn = Counter(wrong_name("mug", draw) for draw in np.linspace(0, 1, 4000, endpoint=False))
    assert drawn["mug"] == 0
    assert drawn[likely[0]] / 4000 == pytest.approx(row.max(), abs=0.002)
    assert wrong_name("something else", 0.5) in names


@pytest.mark.parametrize(
    "wrong",
    [
        {"recall": (0.5,)},
        {"recall": (0.1, 0.2, 0.3, 1.2)},
        {"recall_px": (4, 4, 5, 6)},
        {"hidden": (0.5,)},
        {"far_m": (8.0, 3.0)},
        {"far": (1.1, 0.5)},
        {"auroc": 0.4},
        {"auroc": 1.0},
        {"false_labels": -0.1},
        {"false_positives": 99.0},
        {"jitter": 1.0},
    ],
)
def test_rates_that_cannot_be_are_refused(wrong: dict) -> None:
    with pytest.raises(ConfigError, match="rates"):
        Rates(**wrong)
