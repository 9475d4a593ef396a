from __future__ import annotations

import hashlib

import numpy as np
import pytest

from models.agents.frontier import FrontierAgent
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors import Frame, GtDetector

STEPS = (1, 1, 1, 0, 0, 4, 4, 5, 2, 0, 3, 0, 2, 0, 0, 5)


def frame(counts: list[int], instance: np.ndarray) -> Frame:
    depth = np.ones(instance.shape, np.float32)
    return Frame(
        depth, None, np.zeros(4, np.float32), 1.25, 90.0, instance.astype(np.int16), np.array(counts, np.int32)
    )


def test_tracks_count_up_by_size_among_the_newly_seen() -> None:
    detector = GtDetector()
    detector.reset("e", ("walls", "mug", "bed", "book"))
    image = np.array([[0, 1], [2, -1]])
    found = detector.detect(frame([9, 4, 20, 3], image))
    assert found.track.tolist() == [0, 1, 2]
    assert found.category == ("bed", "walls", "mug")
    assert found.pixels.tolist() == [20, 9, 4]
    assert found.image.tolist() == [[1, 2], [0, -1]]
    assert (found.track.dtype, found.pixels.dtype, found.image.dtype) == (np.int16, np.int32, np.int16)
    assert found.score is None
    assert detector.tracks_of((3, 1)) == (2,)
    found = detector.detect(frame([0, 0, 30, 30], image))
    assert found.category == ("bed", "book")
    assert found.track.tolist() == [0, 3]
    detector.reset("f", ("mug",))
    assert detector.tracks_of((0,)) == ()


def test_least_pixels_can_be_set() -> None:
    detector = GtDetector(min_pixels=10)
    detector.reset("e", ("mug", "bed"))
    assert detector.detect(frame([9, 10], np.array([[0, 1]]))).category == ("bed",)
    with pytest.raises(ConfigError, match="min_pixels=0"):
        GtDetector(min_pixels=0)


def test_range_is_that_of_the_nearest_pixel() -> None:
    detector = GtDetector(range_m=2.0)
    detector.reset("e", ("mug", "bed"))
    image, seen = np.array([[0, 1], [1, -1]]), frame([9, 10], np.array([[0, 1], [1, -1]]))
    seen.depth[:] = [[2.5, 2.5], [1.5, 0.0]]
    found = detector.detect(seen)
    assert (found.category, found.image.tolist()) == (("bed",), [[-1, 0], [0, -1]])
    near = frame([9, 10], image)
    assert detector.detect(near).category == ("bed", "mug")
    assert detector.detect(seen).category == ("bed",), "what was known is not named from afar either"
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ConfigError, match=r"range_m=.*expected metres above 0"):
            GtDetector(range_m=wrong)


def test_in_a_home_it_says_what_a_plain_reading_of_the_truth_says() -> None:
    """Tracks are numbered by first sight, larger first, ties by instance; ``detector=True`` gives the same."""
    numbers: dict[int, int] = {}
    envs = [UcONEnv("mini", detector=d, habit_level="none") for d in (True, GtDetector())]
    looks = [env.reset(options={"episode": 2}) for env in envs]
    for action in STEPS:
        counts = envs[0].search.counts
        seen = [k for k in range(len(counts)) if counts[k] >= 4]
        for k in sorted((k for k in seen if k not in numbers), key=lambda k: (-counts[k], k)):
            numbers[k] = len(numbers)
        seen.sort(key=lambda k: numbers[k])
        image = np.vectorize(lambda k: numbers.get(k, -1))(envs[0]._instance)
        for _, info in looks:
            found = info["detections"]
            assert found.track.tolist() == [numbers[k] for k in seen]
            assert list(found.category) == [envs[0].search.world.categories[k] for k in seen]
            assert found.pixels.tolist() == counts[seen].tolist()
            assert (info["tracks"] == image).all()
        looks = [(obs, info) for obs, _, _, _, info in (env.step(action) for env in envs)]
    assert len(numbers) > 10
    for env in envs:
        env.close()


def test_episodes_are_played_as_before_there_were_other_detectors() -> None:
    """Detections equal those of the code before other detectors existed, by their hash."""
    env = UcONEnv("mini", detector=True, habit_level="none")
    digest = hashlib.sha256()
    for number in range(4):
        info = env.reset(options={"episode": number})[1]
        for action in STEPS:
            found = info["detections"]
            for array in (found.track, found.pixels, info["tracks"]):
                digest.update(str(array.dtype).encode() + array.tobytes())
            digest.update(repr((found.category, info["opened"], type(found.category))).encode())
            info = env.step(action)[4]
    assert digest.hexdigest() == "3fa91201c86c27e91840f98f163b8fc45c88361ea49110bb0d4bb2e307d533b9"
    env.close()


def test_agents_act_as_before_there_were_other_detectors() -> None:
    env, agent, played = UcONEnv("mini", observe="symbolic", detector=True), FrontierAgent(), []
    for number in range(6):
        obs, info = env.reset(seed=0, options={"episode": number})
        agent.reset([info])
        actions, ended = "", False
        while not ended:
            action = agent.act([obs], [info])[0]
            obs, _, terminated, truncated, info = env.step(action)
            actions, ended = actions + str(int(action)), terminated or truncated
        played.append(actions)
    found = hashlib.sha256("\n".join(played).encode()).hexdigest()
    assert found == "3b2a40fa0a32bd45e8a4225fc1ac5a896d4458597e80df38bd4dc2af57505b44"
    env.close()


def test_an_option_that_is_no_detector_is_refused() -> None:
    with pytest.raises(ConfigError, match="expected true"):
        UcONEnv("mini", detector="gt")


@pytest.mark.parametrize("off", [False, None])
def test_without_a_detector_nothing_is_detected(off: bool | None) -> None:
    env = UcONEnv("mini", detector=off, observe="symbolic", habit_level="none")
    obs, info = env.reset(options={"episode": 0})
    assert not {"detections", "tracks", "opened", "depth"} & (obs.keys() | info.keys())
    env.close()
