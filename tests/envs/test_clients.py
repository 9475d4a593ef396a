"""Third-party programs on our environments: checkers, vector environments, learners and video recorders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import ucon.envs
from ucon.envs.checking.subject import OURS

assert ucon.envs
pytestmark = pytest.mark.filterwarnings("ignore")
#: Symbolic where possible: these tests are about interfaces, not images.
SYMBOLIC: dict[str, dict[str, Any]] = {name: {"observe": "symbolic"} for name in OURS if name != "UcONImageGoal-v0"}

#: The column of ``ego`` with the elapsed share of the episode.
_STEP = 6


def options(name: str) -> dict[str, Any]:
    return SYMBOLIC.get(name, {})


@pytest.mark.parametrize("name", OURS)
def test_gymnasium_accepts_them(name: str) -> None:
    check_env(gym.make(name, render_mode="rgb_array", **options(name)).unwrapped)


@pytest.mark.parametrize("name", OURS)
def test_stable_baselines_accepts_them(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="pip install 'ucon-nav[clients]'")
    checker.check_env(gym.make(name, **options(name)))


@pytest.mark.parametrize("name", OURS)
def test_torchrl_accepts_them(name: str) -> None:
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    check_env_specs(GymWrapper(gym.make(name, **options(name))))


@pytest.mark.parametrize("name", OURS)
def test_torchrl_accepts_two_side_by_side(name: str) -> None:
    """The vector environment that ``GymEnv(name, num_envs=2, ...)`` makes, in one process."""
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    def make() -> Any:
        return gym.make(name, texts=False, **options(name))

    def two() -> Any:
        vector = gym.vector.SyncVectorEnv([make] * 2, autoreset_mode=gym.vector.AutoresetMode.SAME_STEP)
        return GymWrapper(vector, categorical_action_encoding=True)

    check_env_specs(two())
    assert "state" not in list(two().reset().keys()), "TorchRL gives it another name, and misses it at the end"


def test_torchrl_goes_on_after_the_end() -> None:
    import torch
    from torchrl.envs import GymWrapper

    def make() -> Any:
        return gym.make("UcON-v0", texts=False, observe="symbolic")

    vector = gym.vector.SyncVectorEnv([make] * 2, autoreset_mode=gym.vector.AutoresetMode.SAME_STEP)
    env = GymWrapper(vector, categorical_action_encoding=True)
    played = env.rollout(8, lambda td: td.set("action", torch.tensor([6, 2])), break_when_any_done=False)
    assert played["next", "done"][0].all()  # Done ends the episode, and the next one begins
    assert not played["next", "done"][1].any()
    assert played["step"][0].max() == 0


def test_torchrl_goes_on_after_the_end_of_a_search_by_views() -> None:
    from torchrl.envs import GymWrapper

    def make() -> Any:
        return gym.make("UcONSearch-v0", texts=False)

    vector = gym.vector.SyncVectorEnv([make] * 2, autoreset_mode=gym.vector.AutoresetMode.SAME_STEP)
    env = GymWrapper(vector, categorical_action_encoding=True)
    env.set_seed(0)
    played = env.rollout(
        80, lambda td: td.set("action", td["action_mask"].long().argmax(-1)), break_when_any_done=False
    )
    ended, steps = played["next", "done"][:, :-1, 0], played["ego"][..., _STEP]
    assert ended.any()
    assert steps[:, 1:][ended].max() < 0.02 < steps[:, :-1].max()


@pytest.mark.slow
@pytest.mark.parametrize("name", OURS)
def test_torchrl_makes_two_in_processes(name: str) -> None:
    from torchrl.envs import GymEnv  # its processes find our ids only with the prefix `ucon:`

    env = GymEnv(f"ucon:{name}", num_envs=2, **options(name))
    try:
        assert env.rollout(6, break_when_any_done=False).shape == (2, 6)
    finally:
        env.close()


@pytest.mark.slow
@pytest.mark.parametrize("context", ["spawn", "forkserver"])
@pytest.mark.parametrize("name", OURS)
def test_vectors_in_processes_are_those_in_one(name: str, context: str) -> None:
    there = gym.make_vec(name, 2, vectorization_mode="async", vector_kwargs={"context": context}, **options(name))
    here = gym.make_vec(name, 2, vectorization_mode="sync", **options(name))
    try:
        seen = [vector.reset(seed=[1, 2])[0] for vector in (there, here)]
        for _ in range(4):
            assert all(np.array_equal(seen[0][key], seen[1][key]) for key in seen[0])
            mask = seen[0].get("action_mask")
            acts = np.array([1, 2]) if mask is None else mask.argmax(1)
            seen = [vector.step(acts)[0] for vector in (there, here)]
    finally:
        there.close()
        here.close()


@pytest.mark.parametrize("learner", ["PPO", "A2C", "DQN"])
def test_stable_baselines_learns(learner: str) -> None:
    sb3 = pytest.importorskip("stable_baselines3", reason="pip install 'ucon-nav[clients]'")
    few = {"DQN": {"learning_starts": 8, "buffer_size": 64, "batch_size": 8}, "A2C": {"n_steps": 8}}
    kwargs = few.get(learner, {"n_steps": 16, "batch_size": 8, "n_epochs": 1})
    model = getattr(sb3, learner)("MultiInputPolicy", gym.make("UcON-v0", observe="symbolic"), device="cpu", **kwargs)
    before = [p.detach().clone() for p in model.policy.parameters()]
    model.learn(24)
    assert any((a != b).any() for a, b in zip(before, model.policy.parameters(), strict=True))


def test_stable_baselines_learns_from_pixels() -> None:
    sb3 = pytest.importorskip("stable_baselines3", reason="pip install 'ucon-nav[clients]'")
    env = gym.make("UcON-v0", width_px=64, height_px=64)
    sb3.PPO("MultiInputPolicy", env, device="cpu", n_steps=8, batch_size=8, n_epochs=1).learn(8)


@pytest.mark.parametrize("name", OURS)
def test_a_masked_policy_is_trained(name: str) -> None:
    contrib = pytest.importorskip("sb3_contrib", reason="pip install 'ucon-nav[clients]'")
    env = gym.make(name, **options(name))
    model = contrib.MaskablePPO("MultiInputPolicy", env, device="cpu", n_steps=8, batch_size=8, n_epochs=1, seed=0)
    model.learn(8)
    masks, acts = model.rollout_buffer.action_masks.reshape(8, -1), model.rollout_buffer.actions.reshape(8)
    assert masks[np.arange(8), acts.astype(int)].all()
    assert (masks.sum(1) < masks.shape[1]).any() == ("UcON-v0" != name != "UcONImageGoal-v0")


def test_successes_are_counted(tmp_path: Path) -> None:
    """``info["is_success"]`` is what Stable-Baselines3 counts: here for an agent that solves every second episode."""
    sb3 = pytest.importorskip("stable_baselines3", reason="pip install 'ucon-nav[clients]'")
    from stable_baselines3.common.callbacks import EvalCallback
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor

    class Solves:
        """Solves every second episode by its stored solution; in the others it says Done at once."""

        def __init__(self, env: Any) -> None:
            self.env, self.plan, self.number = env, iter(()), 0

        def predict(self, obs: Any, *_: Any, **__: Any) -> Any:
            if not obs["last_action"].any():
                self.number += 1
                self.plan = iter(self.env.unwrapped.episode.solution if self.number % 2 else "6")
            return np.array([int(next(self.plan))]), None

    inner = gym.make("UcON-v0", observe="symbolic")
    env = Monitor(inner, str(tmp_path / "monitor"), info_keywords=("is_success",))
    found: list[bool] = []

    def note(local: Any, _: Any) -> None:
        if local["done"]:
            found.append(local["info"]["is_success"])

    evaluate_policy(Solves(inner), env, n_eval_episodes=4, callback=note)
    assert found == [True, False, True, False]
    callback = EvalCallback(env, n_eval_episodes=1, eval_freq=8, log_path=str(tmp_path), verbose=0)
    model = sb3.PPO("MultiInputPolicy", gym.make("UcON-v0", observe="symbolic"), device="cpu", n_steps=8, batch_size=8)
    model.learn(8, callback=callback)
    assert callback._is_success_buffer in ([True], [False])


def test_recorded_videos_show_what_lies_between_choices(tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="Gymnasium's RecordVideo writes with moviepy, which is not installed")
    import cv2

    from ucon.envs.recording import RecordVideo

    inner = gym.make("UcONSearch-v0", render_mode="rgb_array_list")
    env = RecordVideo(inner, str(tmp_path), episode_trigger=lambda number: number == 0, disable_logger=True)
    env.reset(options={"episode": 0})
    for _ in range(5):
        env.step(0)
    steps = env.unwrapped.env._ledger.steps  # type: ignore[attr-defined]
    assert len(env.recorded_frames) == steps + 1 > 10
    env.close()
    video = cv2.VideoCapture(str(next(tmp_path.glob("*.mp4"))))
    shown = 0
    while video.read()[0]:
        shown += 1
    assert shown >= steps  # the writer may drop the last frame by rounding
