"""UcON-v0 through the Gymnasium API: contract, determinism, and no privileged information for the agent."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.ucon_env import Nav, UcONEnv
from ucon.retrieval.context import ContextHabits
from ucon.retrieval.levels import LEVELS
from ucon.task.actions import Action
from ucon.task.episode import Episode
from ucon.task.reward import Reward
from ucon.task.sets import load_episodes

ACTIONS = [0, 0, 1, 0, 2, 3, 5, 4, 4, 0, 0, 1, 5, 0, 3, 0, 0, 2, 0, 0]


def same(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.tobytes() == b.tobytes()
    if isinstance(a, ContextHabits):
        return same((a.rows, a.texts), (b.rows, b.texts))
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if hasattr(a, "__slots__"):
        return all(same(getattr(a, k), getattr(b, k)) for k in a.__slots__)
    return bool(a == b)


def rollout(env: UcONEnv, episode: Episode | None = None, seed: int | None = None) -> list[Any]:
    options = {} if episode is None else {"episode": episode}
    seen: list[Any] = [env.reset(seed=seed, options=options)]
    seen += [env.step(action) for action in ACTIONS]
    return seen


@pytest.mark.filterwarnings("ignore:.*")
@pytest.mark.parametrize("observe", ["pixels", "symbolic"])
@pytest.mark.parametrize("task", ["paper", "released_code"])
def test_gymnasium_check_env(observe: str, task: str) -> None:
    env = gym.make("UcON-v0", observe=observe, task=task, render_mode="rgb_array")
    check_env(env.unwrapped)


def test_torchrl_check_env_specs() -> None:
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    check_env_specs(GymWrapper(gym.make("UcON-v0")))


@pytest.mark.parametrize("level", LEVELS)
def test_two_environments_with_one_seed_are_identical(level: str, episodes: tuple[Episode, ...]) -> None:
    make = lambda: UcONEnv(episodes, habit_level=level, detector=True)  # noqa: E731
    a, b = rollout(make(), seed=3), rollout(make(), seed=3)
    assert all(same(x, y) for x, y in zip(a, b, strict=True))
    other = rollout(make(), seed=4)
    assert not all(same(x, y) for x, y in zip(a, other, strict=True))


def test_an_episode_does_not_depend_on_what_was_played_before(episodes: tuple[Episode, ...]) -> None:
    fresh = rollout(UcONEnv(episodes, detector=True), episodes[1])
    used = UcONEnv(episodes, detector=True)
    for episode in episodes:
        rollout(used, episode)
    assert all(same(x, y) for x, y in zip(fresh, rollout(used, episodes[1]), strict=True))


def test_the_stored_solution_succeeds_and_is_shortest(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic")
    for episode in episodes:
        env.reset(options={"episode": episode})
        for digit in episode.solution[:-1]:
            assert env.step(int(digit))[2:4] == (False, False)
        _, reward, terminated, _, info = env.step(int(Action.DONE))
        assert terminated
        assert info["episode_metrics"]["spl"] == 1.0
        assert float(reward) == pytest.approx(10.0 - 0.01)


def test_step_limit_truncates(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic")
    env.reset(options={"episode": 0})
    for number in range(1, 301):
        _, _, terminated, truncated, info = env.step(int(Action.ROTATE_LEFT))
        assert not terminated
        assert truncated == (number == 300)
    assert info["episode_metrics"]["steps"] == 300


def test_blocked_move_costs_a_step_and_raises_the_flag(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic")
    obs, _ = env.reset(options={"episode": 0})
    assert obs["collision"] == 0
    for _ in range(200):
        before = obs["pose"]
        obs, *_ = env.step(int(Action.MOVE_AHEAD))
        if obs["collision"]:
            assert (obs["pose"] == before).all()
            return
        assert np.abs(obs["pose"][:2] - before[:2]).sum() == pytest.approx(0.25, abs=1e-6)
    pytest.fail("never met a wall")


def test_episodes_are_chosen_by_number_and_by_name(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic")
    for number, episode in enumerate(episodes):
        for wanted in (number, np.int64(number), f"{episode.id[:2]}{episode.id[2:]}"):
            assert env.reset(options={"episode": wanted})[1]["episode"] == episode.id
    with pytest.raises(EpisodeError, match="no episode 'x' among the"):
        env.reset(options={"episode": "x"})
    with pytest.raises(EpisodeError, match=f"expected 0 to {len(episodes) - 1}"):
        env.reset(options={"episode": len(episodes)})


def test_progress_reward_sums_to_the_distance_closed(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic", reward=Reward(success=0.0, step=0.0, progress=1.0))
    for episode in episodes:
        env.reset(options={"episode": episode})
        total = sum(float(env.step(int(d))[1]) for d in episode.solution)
        assert total == pytest.approx(episode.shortest_path_m)


def _names(value: Any, found: set[str]) -> set[str]:
    if isinstance(value, dict | Nav):
        for key, item in (vars(value) if isinstance(value, Nav) else value).items():
            found.add(str(key))
            _names(item, found)
    return found


def test_nothing_privileged_is_given(episodes: tuple[Episode, ...]) -> None:
    allowed_info = {
        "target", "episode", "task", "context", "habit_level", "habits", "habit_rows", "nav", "free", "start",
        "camera_m", "fov_deg", "detections", "tracks", "opened", "depth", "episode_metrics",
        "is_success",
    }  # fmt: skip
    env = UcONEnv(episodes, observe="symbolic", detector=True)
    for episode in episodes:
        obs, info = env.reset(options={"episode": episode})
        assert _names(info, set()) <= allowed_info
        assert set(obs) == set(env.observation_space)
        # Track numbers follow what is seen, not the simulator's numbering, in which the target is among the last.
        assert info["detections"].track.tolist() == list(range(len(info["detections"].track)))
        assert info["tracks"].max() == len(info["detections"].track) - 1
        for action in ACTIONS:
            obs, _, _, _, info = env.step(action)
            assert _names(info, set()) <= allowed_info
            assert (np.diff(info["detections"].track) > 0).all()
    assert "privileged" in UcONEnv(episodes, privileged=True).reset(seed=0)[1]


def test_a_stated_context_tells_when_and_who_and_no_place() -> None:
    episodes = load_episodes("mini", context=True)
    env = UcONEnv(episodes)
    for episode in episodes:
        told = env.reset(options={"episode": episode})[1]["context"]
        asker = episode.context.asker  # type: ignore[union-attr]
        assert told.endswith(f", and this is asked by {asker}.")
        rest = told.removesuffix(f", and this is asked by {asker}.")
        when = r"It is \w+day \w+, about \d+ o'clock, in \w+(, on the occasion '[\w ]+' \(\w+\))?"
        assert re.fullmatch(when, rest), rest


def test_observation_does_not_depend_on_where_the_target_is(episodes: tuple[Episode, ...]) -> None:
    """Another target in the same arrangement changes only the name of the target."""
    first = episodes[0]
    others = [k for k, origin in enumerate(first.placed_by) if origin[0] and k != first.target]
    env = UcONEnv(episodes, habit_level="full", detector=True)
    a, info = env.reset(options={"episode": first})
    b, other = env.reset(options={"episode": replace(first, target=others[0])})
    assert not same(a.pop("target"), b.pop("target"))
    assert info.pop("target") != other.pop("target")
    assert same(a, b)
    assert same(info, other)


@pytest.mark.parametrize("level", ["none", "full", "context"])
def test_an_unseen_target_leaves_no_trace(level: str, episodes: tuple[Episode, ...]) -> None:
    """Without the target in the world, the agent gets the same data until it would see the target."""
    envs = [UcONEnv(episodes, habit_level=level, detector=True) for _ in range(2)]
    steps = 0
    for episode in episodes:
        objects = list(episode.arrangement.objects)
        objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
        without = replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))
        a, b = (env.reset(options={"episode": e}) for env, e in zip(envs, (episode, without), strict=True))
        for action in ACTIONS:
            if envs[0].search.counts[envs[0].search.target]:
                break
            assert same(a, b)
            steps += 1
            a, b = (env.step(action) for env in envs)
    assert steps > 50


def test_levels_give_what_they_say(episodes: tuple[Episode, ...]) -> None:
    rows = {}
    for level in LEVELS:
        env = UcONEnv(episodes, habit_level=level)
        obs, info = env.reset(options={"episode": 0})
        rows[level] = set(info["habit_rows"])
        assert int(obs["habits_mask"].sum()) == len(info["habits"]) == len(rows[level])
        assert env.habit_table.shape[1] == len(obs["target"])
    assert rows["none"] == set()
    assert len(rows["retrieval"]) == 20
    assert rows["gt"] < rows["full"]
    assert rows["retrieval"] < rows["full"]
    assert rows["context"] == rows["retrieval"]


def test_context_is_retrieval_until_it_is_told_more(episodes: tuple[Episode, ...]) -> None:
    envs = [UcONEnv(episodes, habit_level=level, detector=True) for level in ("retrieval", "context")]
    for a, b in zip(*(rollout(env, episodes[1]) for env in envs), strict=True):
        assert same(a[0], b[0])
        assert set(b[-1]) - set(a[-1]) <= {"reranking"}


def test_observations_follow_the_context(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic", habit_level="context")
    obs, info = env.reset(options={"episode": 0})
    first = obs["habits"].tolist()
    assert info["reranking"].update({"bed", "sofa", "shelf", "desk", "fridge"}, {"bed": 0.5})
    assert info["reranking"].texts != info["habits"]
    obs, *_ = env.step(int(Action.ROTATE_LEFT))
    assert obs["habits"].tolist() != first
    assert obs["habits"][:20].tolist() == info["reranking"].rows.tolist()
    assert obs in env.observation_space
    assert env.reset(options={"episode": 0})[0]["habits"].tolist() == first


def test_render_shows_frame_and_map(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, render_mode="rgb_array")
    env.reset(options={"episode": 0})
    frame = env.render()
    assert frame is not None
    assert frame.shape == (384, 768, 3)
    assert frame[:, :384].std() > 10
    assert frame[:, 384:].std() > 10


def test_other_sizes_judge_by_the_same_view(episodes: tuple[Episode, ...]) -> None:
    """Visibility is decided at 128 x 128, whatever the size of the observation."""
    envs = [UcONEnv(episodes, width_px=w, height_px=h, detector=True) for w, h in ((128, 128), (64, 48), (200, 160))]
    seen = []
    for env in envs:
        obs, info = env.reset(options={"episode": 2})
        assert obs["rgb"].shape == (*info["tracks"].shape, 3)
        found = info["detections"]
        assert found.image is info["tracks"]
        seen.append((found.track, found.pixels, found.category))
    assert all(same(seen[0], other) for other in seen[1:])


@pytest.mark.parametrize(
    ("kwargs", "error", "message"),
    [
        ({"observe": "pixel"}, ConfigError, "observe='pixel'"),
        ({"habit_level": "ful"}, ConfigError, "did you mean full"),
        ({"task": "papr"}, ConfigError, "did you mean paper"),
        ({"renderer": "gl"}, ConfigError, "renderer='gl'"),
        ({"world": "dead"}, ConfigError, "world='dead'"),
        ({"episodes": ()}, EpisodeError, "no episodes"),
        ({"episodes": "nothing_here"}, EpisodeError, "unknown episode set"),
        ({"max_habits": 3}, ConfigError, "give env.max_habits=.*habit_level=retrieval"),
    ],
)
def test_bad_options_end_in_one_clear_line(kwargs: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        UcONEnv(**kwargs).reset(seed=0)


def test_bad_episodes_are_refused(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes)
    for wanted in ("no/such", 10_000):
        with pytest.raises(EpisodeError):
            env.reset(options={"episode": wanted})
    with pytest.raises(EpisodeError, match="make the episodes again"):
        env.reset(options={"episode": replace(episodes[0], home_hash="0" * 64)})
    with pytest.raises(EpisodeError, match="choose those habits"):
        env.reset(options={"episode": replace(episodes[0], habits_hash="0" * 64)})


def test_runs_without_pybullet_and_torch() -> None:
    """An episode in a compiled home imports neither PyBullet nor a deep learning library."""
    code = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("pybullet", "pybullet_data", "torch", "transformers"):
            raise ImportError(name + " is blocked")
sys.meta_path.insert(0, Block())
import gymnasium, ucon.envs
env = gymnasium.make("UcON-v0", detector=True)
env.reset(seed=0)
for action in (0, 1, 5, 0, 2, 3, 6):
    env.step(action)
print("fine")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.strip().endswith("fine"), done.stderr


def test_an_episode_is_found_by_its_name(episodes: tuple[Episode, ...]) -> None:
    """Names are compared by value: a newly built string finds the episode too."""
    env = UcONEnv(episodes)
    for episode in episodes[:3]:
        spelled = "".join(list(episode.id))
        assert env.reset(options={"episode": spelled})[1]["episode"] == episode.id
    with pytest.raises(EpisodeError, match="no episode 'nowhere/000' among the"):
        env.reset(options={"episode": "nowhere/000"})
