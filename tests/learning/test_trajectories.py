"""Trajectories as data and their replays, which must not depend on memory and workers."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.learning.tiny_policy import ENV, TinyPolicy
from ucon.core.errors import DataError
from ucon.learning.imitation.feeding import Feeder, _packed, _unpacked
from ucon.learning.imitation.replaying import Replayer
from ucon.learning.imitation.trajectories import (
    IGNORED,
    Replay,
    Trajectory,
    demonstration,
    returns,
    trajectories_from_json,
)
from ucon.task.sets import load_episodes

EPISODES = sorted(load_episodes("mini"), key=lambda episode: len(episode.solution))[:4]


def same(a: Replay, b: Replay) -> bool:
    def equal(x, y):
        kinds = [(n, v.dtype, v.shape, v.tobytes()) for n, v in sorted(x.items())]
        return kinds == [(n, v.dtype, v.shape, v.tobytes()) for n, v in sorted(y.items())]

    return equal(a.context, b.context) and equal(a.frames, b.frames) and a.rewards.tobytes() == b.rewards.tobytes()


def test_plain_data_and_back():
    strayed = Trajectory(EPISODES[0], "gt", "0123", "01.3")
    led = Trajectory(EPISODES[0], "gt", "3", "3", led="012")
    rows = [demonstration(EPISODES[1], "none").to_json(), strayed.to_json(), led.to_json()]
    by_id = {episode.id: episode for episode in EPISODES}
    assert trajectories_from_json(rows, by_id) == [demonstration(EPISODES[1], "none"), strayed, led]
    assert strayed.classes.tolist() == [0, 1, IGNORED, 3]
    assert strayed.n_labels == 3
    name = EPISODES[0].id
    unlike = (["x", "gt", "0", "0"], [name, "gt", "01", "0"], [name, "gt", "9", "0"], [*rows[2][:4], "x"], 7)
    for wrong in unlike:
        with pytest.raises(DataError, match="trajectory of other episodes"):
            trajectories_from_json([wrong], by_id)


def test_returns_are_discounted_from_the_end():
    assert returns(np.array([1, 0, 4], np.float32), 0.5).tolist() == [2.0, 2.0, 4.0]


def test_a_replay_is_what_the_environment_shows():
    episode, policy, env = EPISODES[0], TinyPolicy(), ENV()
    found = Replayer(policy, ENV)(demonstration(episode, "retrieval"))
    observation, info = env.reset(options={"episode": episode, "habit_level": "retrieval"})
    assert found.context["habits"] == np.float32(0.2)
    assert len(found) == len(episode.solution)
    for step, digit in enumerate(episode.solution):
        frame = policy.frame(observation, info)
        assert found.frames["depth"][step].tobytes() == frame["depth"].tobytes()
        observation, reward, *_ = env.step(int(digit))
        assert found.rewards[step] == np.float32(reward)
    assert found.rewards[-1] > 9


def test_the_level_is_the_trajectory_s():
    replay = Replayer(TinyPolicy(), ENV)
    told = [float(replay(demonstration(EPISODES[0], level)).context["habits"][0]) for level in ("none", "full", "none")]
    assert told[0] == told[2] == 0
    assert told[1] > 3


def test_actions_after_the_end_are_refused():
    long = Trajectory(EPISODES[0], "none", EPISODES[0].solution + "0", EPISODES[0].solution + "0")
    with pytest.raises(DataError, match="actions after its end"):
        Replayer(TinyPolicy(), ENV)(long)


def test_what_is_kept_is_what_was_made():
    """Scalars stay scalars, and dtypes stay the same."""
    arrays = {"a": np.array(3), "b": np.zeros((2, 3), np.float16).T, "c": np.array([True, False])}
    replay = Replay(arrays, arrays, np.ones(2, np.float32))
    assert same(_unpacked(_packed(replay)), replay)


class Counting(TinyPolicy):
    """Counts the calls of its frozen part."""

    def __init__(self):
        super().__init__()
        self.asked = 0

    def features(self, frames):
        if "depth" not in frames:
            return frames
        self.asked += 1
        return {"did": frames["did"], "half": frames["depth"] * 0.5}


def test_memory_changes_nothing_but_how_often_frozen_parts_are_asked():
    batches = [[demonstration(episode, "none") for episode in EPISODES[:2]]] * 3
    asked = []
    for room in (0, 3000, 1 << 20):
        policy = Counting()
        fed = list(Feeder(policy, ENV, memory_bytes=room)(batches))
        asked.append(policy.asked)
        assert [t for t, _ in fed[2]] == batches[0]
        assert all(same(a, b) for batch in fed for (_, a), (_, b) in zip(batch, fed[0], strict=True))
        assert {"did", "half"} == set(fed[0][0][1].frames)
    assert asked[0] == 6
    assert asked[2] == 2
    assert 2 <= asked[1] <= 6


@pytest.mark.slow
def test_workers_change_nothing():
    batches = [[demonstration(EPISODES[(k + i) % 4], ("none", "gt")[k % 2]) for i in range(2)] for k in range(6)]
    alone = [replay for batch in Feeder(TinyPolicy(), ENV)(batches) for _, replay in batch]
    feeder = Feeder(TinyPolicy(), ENV, workers=2)
    try:
        shared = [replay for batch in feeder(batches) for _, replay in batch]
    finally:
        feeder.close()
    assert all(same(a, b) for a, b in zip(alone, shared, strict=True))


def test_a_policy_that_reads_no_habits_is_shown_an_episode_once():
    policy = Counting()
    policy.uses_habits = False
    batch = [demonstration(EPISODES[0], level) for level in ("none", "gt", "full")]
    list(Feeder(policy, ENV)([batch]))
    assert policy.asked == 1


def test_changes_are_against_what_was_done():
    strayed = Trajectory(EPISODES[0], "gt", "0020", "0.00")
    assert strayed.changes.tolist() == [True, True, False, True]


def waiting(episodes):
    """Start a worker and wait to be killed."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs of a shell ignore it
    feeder = Feeder(TinyPolicy(), ENV, workers=1)
    print(next(feeder([[demonstration(episodes[0], "none")]] * 9))[0][1].rewards.sum(), flush=True)  # noqa: T201
    time.sleep(600)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_workers_end_with_their_learner(number):
    """No worker is left running, whatever ends the learner."""
    code = "from tests.learning.test_trajectories import *; waiting(EPISODES) if __name__ == '__main__' else None"
    learner = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert learner.stdout is not None
    assert float(learner.stdout.readline()) > 9
    children = subprocess.run(["pgrep", "-P", str(learner.pid)], capture_output=True, text=True).stdout.split()
    assert children
    learner.send_signal(number)
    learner.wait(180)
    until = time.monotonic() + 120
    while (left := [pid for pid in children if Path(f"/proc/{pid}/stat").exists()]) and time.monotonic() < until:
        time.sleep(0.1)
    assert not left
