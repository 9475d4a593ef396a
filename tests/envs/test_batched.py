"""Many homes as one TorchRL environment: equal to single environments, and images are not copied."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import torch
from torchrl.collectors import Collector
from torchrl.envs.utils import check_env_specs

from ucon.core.errors import ActionError, ConfigError, EpisodeError
from ucon.core.rng import stream
from ucon.envs.batched import MOST_SLOTS, BatchedUcONEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.task.actions import Action
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")[:6]
SLOTS = 3
DONE = int(Action.DONE)


def batched(**options: Any) -> BatchedUcONEnv:
    return BatchedUcONEnv(SLOTS, EPISODES, **options)


def actions_of(steps: int, *, done: float = 0.0) -> torch.Tensor:
    """(steps, SLOTS): random actions, Done with some probability."""
    p = np.full(7, (1 - done) / 6)
    p[DONE] = done
    return torch.from_numpy(stream(0, "test", "batched").choice(7, size=(steps, SLOTS), p=p))


def played(env: BatchedUcONEnv, actions: torch.Tensor) -> Any:
    """A rollout that continues past the ends of episodes, (SLOTS, steps)."""
    turn = iter(actions)
    return env.rollout(len(actions), lambda td: td.set("action", next(turn)), break_when_any_done=False)


@pytest.mark.parametrize("options", [{}, {"observe": "symbolic"}, {"width_px": 48, "height_px": 32}], ids=str)
def test_torchrl_accepts_it(options: dict[str, Any]) -> None:
    check_env_specs(batched(**options))


@pytest.mark.parametrize(
    "options", [{}, {"task": "real_robot"}, {"observe": "symbolic", "habit_level": "full"}], ids=str
)
def test_a_slot_is_an_environment(options: dict[str, Any]) -> None:
    """Compared entry by entry and step by step, past the ends of episodes."""
    actions = actions_of(40, done=0.05)
    seen = played(batched(seed=4, **options), actions)
    assert seen["next", "done"].sum() > SLOTS, "too few ends to show anything"
    for slot in range(SLOTS):
        env = UcONEnv(EPISODES, planner="observed", **options)
        begun, now = 0, None
        for step in range(len(actions)):
            if now is None:
                index = int(stream(4, "slot", slot, begun).integers(len(EPISODES)))
                now, begun = env.reset(seed=0, options={"episode": index})[0], begun + 1
            row = seen[slot, step]
            assert all(np.array_equal(row[name].numpy(), value) for name, value in now.items())
            now, reward, terminated, truncated, info = env.step(int(actions[step, slot]))
            assert all(np.array_equal(row["next", name].numpy(), value) for name, value in now.items())
            assert row["next", "reward"].item() == np.float32(reward)
            assert row["next", "terminated"].item() is terminated
            assert row["next", "truncated"].item() is truncated
            spl = info["episode_metrics"]["spl"] if terminated or truncated else 0.0
            assert row["next", "spl"].item() == np.float32(spl)
            if terminated or truncated:
                now = None


def test_a_solution_succeeds_and_a_limit_truncates() -> None:
    env = BatchedUcONEnv(1, [EPISODES[0]], observe="symbolic")
    solution = torch.tensor([[int(digit)] for digit in EPISODES[0].solution])
    end = env.rollout(len(solution), lambda td: td.set("action", solution[int(td["step"])]))[0, -1]["next"]
    assert (end["success"], end["spl"], end["terminated"]) == (1.0, 1.0, True)
    assert end["reward"] > 9
    turns = env.rollout(400, lambda td: td.set("action", torch.tensor([1])))
    assert turns.shape == (1, 300)
    assert turns[0, -1]["next", "truncated"]
    assert not turns["next", "success"].any()


def test_a_seed_decides_the_episodes_of_every_slot() -> None:
    """This holds whatever was played before, and whatever the other slots do."""
    env, actions = batched(observe="symbolic"), actions_of(12, done=0.3)
    env.set_seed(7)
    first = played(env, actions)
    env.set_seed(7)
    assert (played(env, actions)["next", "pose"] == first["next", "pose"]).all()
    others = actions.clone()
    others[:, 1:] = 1
    env.set_seed(7)
    again = played(env, others)
    assert (again[0]["target"] == first[0]["target"]).all()
    assert not (again[1]["pose"] == first[1]["pose"]).all()
    env.set_seed(8)
    assert not (played(env, actions)["target"] == first["target"]).all()


def test_the_renderer_writes_into_the_tensors() -> None:
    env = batched()
    before = env.reset()
    kept = before["rgb"].clone()
    after = env.step(before.set("action", torch.ones(SLOTS, dtype=torch.int64)))
    assert (after["rgb"] == kept).all(), "an observation changes after it was given"
    assert not (after["next", "rgb"] == kept).all()
    for slot, one in enumerate(env._slots):
        assert one._images is not None
        assert one._images[0].ctypes.data == after["next", "rgb"][slot].data_ptr()
        assert one._images[1].ctypes.data == after["next", "depth"][slot].data_ptr()


def test_slots_that_are_not_stepped_stay_as_they_are() -> None:
    env = batched()
    now = env.reset().set("action", torch.tensor([0, 1, 2]))
    now["_step"] = torch.tensor([True, False, True])
    after = env.step(now.clone())["next"]
    assert (after["rgb"][1] == now["rgb"][1]).all()
    assert after["step"].flatten().tolist() == [1, 0, 1]
    ends = env.rollout(
        310, lambda td: td.set("action", torch.tensor([6, 1, 1])), break_when_any_done=False, break_when_all_done=True
    )
    assert ends.shape == (SLOTS, 300)


def test_a_collector_gives_what_a_rollout_sees() -> None:

    def policy(td: Any) -> Any:
        return td.set("action", (2 * td["step"].flatten() + torch.arange(SLOTS)) % 7)

    seen = batched(seed=1).rollout(20, policy, break_when_any_done=False)
    assert seen["next", "done"].any()
    collector = Collector(
        batched(seed=1),
        policy,
        frames_per_batch=20 * SLOTS,
        total_frames=20 * SLOTS,
        compact_obs=True,
    )
    (batch,) = list(collector)
    assert (batch["rgb"] == seen["rgb"]).all()
    assert (batch["depth"] == seen["depth"]).all()
    assert (batch["next", "reward"] == seen["next", "reward"]).all()


def test_what_cannot_be_done_is_refused_before_anything_is_done() -> None:
    env = batched(observe="symbolic")
    now = env.reset()
    with pytest.raises(ActionError, match=r"action=7 of slot 2: expected a whole number from 0 to 6"):
        env.step(now.clone().set("action", torch.tensor([0, 0, 7])))
    after = env.step(now.clone().set("action", torch.tensor([1, 6, 1])))["next"]
    assert after["step"].flatten().tolist() == [1, 1, 1], "slots have moved before the error"
    with pytest.raises(EpisodeError, match="the episode of slot 1 is over: reset that slot"):
        env.step(now.clone().set("action", torch.tensor([1, 1, 1])))


@pytest.mark.parametrize("slots", [0, MOST_SLOTS + 1, 1.5, "4", True])
def test_a_wrong_number_of_slots_is_one_line(slots: Any) -> None:
    with pytest.raises(ConfigError, match=r"^slots=.*: expected a whole number from 1 to 1024$"):
        BatchedUcONEnv(slots, EPISODES)


def test_options_whose_results_are_no_tensors_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"^detector: its results are not tensors"):
        batched(detector=True)


def test_copies_of_an_environment_draw_elsewhere() -> None:
    """A copy does not write into the images of the original."""
    env = UcONEnv(EPISODES)
    images = np.zeros((128, 128, 3), np.uint8), np.zeros((128, 128), np.float32)
    env.reset(seed=0)
    env.draw_images_into(images)
    seen = env.step(1)[0]
    assert seen["rgb"] is images[0]
    kept = images[0].copy()
    assert copy.deepcopy(env).step(1)[0]["rgb"] is not images[0]
    assert (images[0] == kept).all()
    env.draw_images_into(None)
    assert env.step(1)[0]["rgb"] is not images[0]
