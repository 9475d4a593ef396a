"""Episodes end for good: no steps after the end, invalid actions do nothing, and figures stay the same."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from ucon.core.errors import ActionError, ConfigError, EpisodeError
from ucon.envs.checking.findings import same
from ucon.envs.checking.subject import OURS, core, reset, step
from ucon.envs.image_goal import UcONImageGoalEnv
from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.task.actions import Action, decoded_action
from ucon.task.episode import Episode


def played_out(env: gym.Env[Any, Any], *, fails: bool) -> Any:
    """Play to the end: Done at once, or turns (in environments of choices, first choices) until it ends."""
    seen = reset(env, 0)
    while not seen.over:
        choices = "action_mask" in seen.obs
        seen = step(env, 0 if choices else int(Action.DONE if fails else Action.ROTATE_LEFT))
    return seen


@pytest.mark.parametrize("fails", [True, False], ids=["failed Done", "300 steps"])
@pytest.mark.parametrize("name", OURS)
def test_an_episode_that_is_over_takes_no_step(name: str, fails: bool) -> None:
    env = OURS[name](**({} if name == "UcONImageGoal-v0" else {"observe": "symbolic"}))
    last = played_out(env, fails=fails)
    figures = dict(last.info["episode_metrics"])
    assert last.info["is_success"] is figures["success"]
    ledger = core(env)._ledger
    assert ledger is not None
    before = ledger.outcome()
    for action in (0, 0, 6, 0):
        with pytest.raises(EpisodeError, match=r"over.*call reset\(\) first"):
            env.step(action)
    assert last.info["episode_metrics"] == figures
    assert ledger.outcome() == before
    assert not step(env, 0).over if reset(env, 1) and name == "UcON-v0" else True


@pytest.mark.parametrize("wrong", [-1, 7, 1.5, 1.0, float("nan"), "0", None, True, np.array([0]), b"1"], ids=repr)
def test_what_is_no_action_is_refused_and_changes_nothing(wrong: Any) -> None:
    env, alone = (UcONEnv("mini", observe="symbolic") for _ in range(2))
    reset(env, 0), reset(alone, 0)
    with pytest.raises(ActionError, match="expected a whole number from 0 to 6"):
        env.step(wrong)
    assert all(same(tuple(step(env, a)), tuple(step(alone, a))) for a in (0, 2, 0, 5))


@pytest.mark.parametrize("right", [2, np.int64(2), np.uint8(2), np.array(2), Action.ROTATE_LEFT], ids=repr)
def test_whole_numbers_of_all_sorts_are_actions(right: Any) -> None:
    env = UcONEnv("mini", observe="symbolic")
    env.reset(options={"episode": 0})
    assert decoded_action(env.step(right)[0]["last_action"]) == 2


@pytest.mark.parametrize("name", OURS)
def test_nothing_goes_on_before_a_reset_or_after_close(name: str) -> None:
    env = OURS[name](render_mode="rgb_array")
    calls = (lambda: env.step(0), env.render, env.action_masks)
    for round_ in range(2):
        for call in calls:
            with pytest.raises(EpisodeError, match="call reset"):
                call()
        env.reset(options={"episode": round_})
        assert env.action_masks().any()
        assert env.render().std() > 5
        env.step(0)
        env.close()
        env.close()


@pytest.mark.parametrize("name", OURS)
def test_a_reset_that_fails_leaves_nothing_to_go_on_with(name: str) -> None:
    env = OURS[name]()
    env.reset(options={"episode": 0})
    with pytest.raises(EpisodeError, match="no episode"):
        env.reset(options={"episode": "none/such"})
    with pytest.raises(EpisodeError, match="call reset"):
        env.step(0)


def test_all_frames_between_choices_are_shown() -> None:
    env, still = (UcONSearchEnv(render_mode=mode) for mode in ("rgb_array_list", "rgb_array"))
    reset(env, 1), reset(still, 1)
    frames, steps = env.render(), core(env)._ledger.steps
    assert len(frames) == steps + 1
    for _ in range(3):
        seen = step(env, 0)
        step(still, 0)
        frames = env.render()
        assert len(frames) == core(env)._ledger.steps - steps
        assert np.array_equal(frames[-1], still.render())
        steps = core(env)._ledger.steps
        if seen.over:
            break
    assert env.render() == []


def test_a_moment_is_drawn_later_as_it_was(episodes: tuple[Episode, ...]) -> None:
    """This includes moments from before something was opened."""
    env = UcONEnv(episodes, observe="symbolic", render_mode="rgb_array")
    contained = next(e for e in episodes if "5" in e.solution)
    env.reset(options={"episode": contained})
    shown = [(env.moment(), env.render())]
    for digit in contained.solution:
        env.step(int(digit))
        shown.append((env.moment(), env.render()))
    assert shown[-1][0].opened
    for moment, frame in shown[::-7]:
        assert np.array_equal(env.draw(moment), frame)


@pytest.mark.parametrize("env", [UcONEnv, UcONSearchEnv, UcONImageGoalEnv])
def test_no_window_is_opened_and_the_refusal_says_what_there_is(env: Any) -> None:
    with pytest.raises(ConfigError, match=r"no window is opened; give render_mode='rgb_array'") as caught:
        env("mini", render_mode="human")
    assert "\n" not in str(caught.value)
