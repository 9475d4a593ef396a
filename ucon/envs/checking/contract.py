"""Checks that hold for every environment: spaces, seeds, copies, ends of episodes, rendered frames.

Each takes a :class:`~ucon.envs.checking.subject.Subject` and returns one
:class:`~ucon.envs.checking.findings.Finding`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np
from gymnasium import spaces as spaces_of

from ucon.core.errors import UconError
from ucon.envs.checking.findings import Finding, difference, same
from ucon.envs.checking.subject import Env, Step, Subject, choice, core, reset, step
from ucon.task.actions import Action
from ucon.task.episode import Episode

#: Actions of all kinds except Done.
WALK: Final = (0, 0, 1, 0, 2, 3, 5, 4, 4, 0, 0, 1, 5, 0, 3, 0, 0, 2, 0, 0)


def played(subject: Subject, env: Env, first: Step, actions: int = len(WALK), start: int = 0) -> list[Step]:
    """Play some steps, with the same actions in every run.

    Args:
        subject: decides whether actions are choices.
        env: the environment, after its reset.
        first: result of the reset or of the last step.
        actions: most steps to play; fewer if the episode ends earlier.
        start: number of the first action.

    Returns:
        The results of the steps, without ``first``.
    """
    seen = [first]
    for number in range(start, start + actions):
        if seen[-1].over:
            break
        seen.append(step(env, choice(seen[-1], number) if subject.chooses else WALK[number % len(WALK)]))
    return seen[1:]


def _begun(subject: Subject, env: Env) -> list[Step]:
    """A reset with a fixed seed and some steps."""
    first = reset(env, seed=3)
    return [first, *played(subject, env, first)]


def spaces(subject: Subject) -> Finding:
    """Observations lie in their space, rewards are finite, ``terminated`` and ``truncated`` are booleans.

    Two episodes, at the reset and up to twenty steps.
    """
    env, wrong = subject.make(), []
    for episode in (0, 1):
        first = reset(env, episode)
        if not _fits(first.obs, env.observation_space):
            wrong.append("reset")
        raw: Any = None
        seen, number = first, 0
        while not seen.over and number < len(WALK):
            action = choice(seen, number) if subject.chooses else WALK[number]
            raw = env.step(action)
            seen, number = Step(raw[0], float(raw[1]), bool(raw[2]), bool(raw[3]), raw[4]), number + 1
            if not _fits(raw[0], env.observation_space):
                wrong.append(f"step {number}")
            if not np.isfinite(raw[1]) or not all(isinstance(end, bool | np.bool_) for end in raw[2:4]):
                wrong.append(f"reward or end of step {number}")
    expected = "observations in their space, finite rewards, terminated and truncated as booleans"
    return Finding("spaces", not wrong, expected, wrong[0] if wrong else "as expected at all steps")


def seeds(subject: Subject) -> Finding:
    """The same seed gives the same bytes, and other seeds give other episodes.

    Compares two environments with one seed, one of them played twice; eight seeds must give at least two episodes.
    """
    envs = [subject.make() for _ in range(2)]
    runs = [_begun(subject, env) for env in (*envs, envs[0])]
    for run in runs[1:]:
        for number, (a, b) in enumerate(zip(runs[0], run, strict=False)):
            if len(run) != len(runs[0]) or not same(tuple(a), tuple(b)):
                found = f"{difference(a.obs, b.obs)} differs at step {number}"
                return Finding("seeds", False, "the same bytes from the same seed", found)
    drawn = {reset(envs[0], seed=seed).info["episode"] for seed in range(8)}
    expected = "the same bytes from the same seed, other episodes from other seeds"
    return Finding("seeds", len(drawn) > 1, expected, f"{len(drawn)} episodes from 8 seeds")


def episodes(subject: Subject) -> Finding:
    """``options["episode"]`` of ``reset`` selects the episode: by index, by id, or an episode itself."""
    env, known = subject.make(), subject.episodes()
    numbers = [0, len(known) - 1, len(known) // 2]
    asked = [numbers[0], known[numbers[1]].id, known[numbers[2]]]
    found = [reset(env, which).info["episode"] for which in asked]
    wanted = [known[number].id for number in numbers]
    return Finding("episodes", found == wanted, f"the episodes asked for ({wanted[1]})", f"{found[1]}")


def copies(subject: Subject) -> Finding:
    """A deep copy continues from the same state with the same bytes, and does not affect the original.

    One copy plays other actions; the original and a second copy must then play like an environment that was never
    copied.
    """
    env, alone = subject.make(), subject.make()
    half = 2 if subject.chooses else len(WALK) // 2
    first = reset(env, 0)
    played(subject, env, first, half)
    last = ([first, *played(subject, alone, reset(alone, 0), half)])[-1]
    twin = copy.deepcopy(env)
    for number in range(half):  # the first copy plays other actions
        if step(twin, 0 if subject.chooses else int((Action.ROTATE_LEFT, Action.MOVE_AHEAD)[number % 2])).over:
            break
    again = copy.deepcopy(env)
    runs = [played(subject, one, last, half, half) for one in (alone, env, again)]
    for name, run in zip(("the original", "the copy"), runs[1:], strict=True):
        for number, (a, b) in enumerate(zip(runs[0], run, strict=False)):
            if len(run) != len(runs[0]) or not same(tuple(a), tuple(b)):
                found = f"{name} differs in {difference(a.obs, b.obs)}, {number + 1} steps later"
                return Finding("copies", False, "a copy that is independent of the original", found)
    return Finding("copies", True, "a copy that is independent of the original", "as expected")


def actions(subject: Subject) -> Finding:
    """Invalid actions are refused and change nothing: out of range, not whole, NaN, text, None."""
    env, alone = subject.make(), subject.make()
    first, _ = reset(env, 0), reset(alone, 0)
    none = (-1, int(env.action_space.n), 1.5, float("nan"), "0", None)  # type: ignore[attr-defined]
    taken = [action for action in none if not _refused(partial(env.step, action))]
    run, plain = (played(subject, one, first, 3) for one in (env, alone))
    untouched = all(same(tuple(a), tuple(b)) for a, b in zip(run, plain, strict=True))
    found = f"{taken[0]!r} was accepted" if taken else "all refused" if untouched else "they changed later steps"
    return Finding("actions", not taken and untouched, "invalid actions refused, and nothing changed", found)


def after_the_end(subject: Subject) -> Finding:
    """After the end of an episode ``step`` raises, and ``episode_metrics`` stay as they are."""
    env, wrong = subject.make(), []
    for episode in (0, 1):
        last = to_the_end(subject, env, reset(env, episode))
        before = dict(last.info.get("episode_metrics", {}))
        for action in (0, 1, 0):
            if not _refused(partial(env.step, action)):
                wrong.append(f"a step after {'Done' if last.terminated else 'the last step'} was accepted")
                break
        if not same(before, last.info.get("episode_metrics", {})):
            wrong.append("episode_metrics changed")
    if not reset(env, 0).obs:
        wrong.append("no observation after a new reset")
    expected = "an error that asks for a reset, metrics unchanged"
    return Finding("after the end", not wrong, expected, wrong[0] if wrong else "as expected")


def last_step(subject: Subject) -> Finding:
    """An episode without Done is truncated exactly at the last step of the rules.

    The target is placed far below the floor, so that no choice can end the episode.
    """
    env, most = subject.make(), core(subject.make()).rules.max_steps
    seen, taken = reset(env, without_target(subject.episodes()[0])), 0
    while not seen.over and taken <= most + 5:
        seen, taken = step(env, choice(seen, taken) if subject.chooses else int(Action.ROTATE_LEFT)), taken + 1
    steps = int(seen.info.get("episode_metrics", {}).get("steps", -1))
    ok = seen.truncated and not seen.terminated and steps == most and (subject.chooses or taken == most)
    ended = "truncated" if seen.truncated else "terminated" if seen.terminated else "still running"
    return Finding(
        "last step", ok, f"truncated at step {most}", f"{ended} after {taken} actions, {steps} steps in its metrics"
    )


def frames(subject: Subject) -> Finding:
    """``render`` returns frames that change as the agent moves.

    The frames must be uint8 arrays (H, W, 3) with more than one colour.
    """
    env = subject.make(render_mode="rgb_array")
    first = reset(env, 0)
    one: Any = env.render()
    played(subject, env, first, 3)
    two: Any = env.render()
    right = isinstance(one, np.ndarray) and one.dtype == np.uint8 and one.ndim == 3 and one.shape[2] == 3
    ok = bool(right and one.std() > 5 and not np.array_equal(one, two))
    found = f"{getattr(one, 'shape', type(one).__name__)}, {'changing' if not same(one, two) else 'always the same'}"
    env.close()
    return Finding("frames", ok, "uint8 (H, W, 3) that is not of one colour and changes", found)


def without_target(episode: Episode) -> Episode:
    """The same episode with its target 50 m below the floor, where nothing can see or reach it."""
    objects = list(episode.arrangement.objects)
    objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
    return replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))


def to_the_end(subject: Subject, env: Env, first: Step) -> Step:
    """Play until the episode is over, with choices, or with three rotations and Done.

    Args:
        subject: decides whether actions are choices.
        env: the environment, after its reset.
        first: result of the reset.

    Returns:
        The result of the last step.
    """
    seen, number = first, 0
    while not seen.over and number < 400:
        action = choice(seen, number) if subject.chooses else int(Action.DONE if number == 3 else Action.ROTATE_LEFT)
        seen, number = step(env, action), number + 1
    return seen


def _fits(obs: Any, space: Any) -> bool:
    """Whether an observation lies in its space with the right dtype; Gymnasium itself accepts lists as arrays."""
    if isinstance(space, spaces_of.Dict):
        return obs.keys() == space.keys() and all(_fits(obs[name], space[name]) for name in space)
    typed = not isinstance(space, spaces_of.Box) or getattr(obs, "dtype", None) == space.dtype
    return typed and obs in space


def _refused(call: Callable[[], Any]) -> bool:
    """Whether a call is refused with one of UcON's errors or those of Gymnasium's own wrappers."""
    try:
        call()
    except (UconError, AssertionError, ValueError, TypeError):
        return True
    return False
