"""Checks of how episodes end: Done, success, rewards, and the episode's metrics."""

from __future__ import annotations

from typing import Any

from ucon.envs.checking.contract import to_the_end
from ucon.envs.checking.findings import Finding
from ucon.envs.checking.subject import Env, Step, Subject, choice, core, reset, step
from ucon.task.actions import Action


def done(subject: Subject) -> Finding:
    """Done ends the episode: with success where the target is in view and within reach, else without.

    Tested in three episodes, with Done at the start and with the stored solution.
    """
    expected = "Done ends the episode: success at the end of the stored solution, none at the start"
    env, known = subject.make(), subject.episodes()
    for episode in (0, 1, 2):
        reset(env, episode)
        early = step(env, int(Action.DONE))
        seen = _solved(env, reset(env, episode), known[episode].solution)
        found = [(s.terminated, s.truncated, _success(s)) for s in (early, seen)]
        if found != [(True, False, False), (True, False, True)]:
            said = "; ".join(f"terminated {t}, truncated {u}, success {s}" for t, u, s in found)
            return Finding("done", False, expected, f"at the start and at the end: {said}")
    return Finding("done", True, expected, "as expected in 3 episodes")


def rewards(subject: Subject) -> Finding:
    """Success has the highest reward, and a failed Done no more than an ordinary step."""
    expected = "the highest reward for success, no more than a step for a failed Done"
    env, known = subject.make(), subject.episodes()
    reset(env, 0)
    usual = [step(env, action).reward for action in (2, 2, 1, 3, 4, 2, 2)]
    failed = step(env, int(Action.DONE)).reward
    success = _solved(env, reset(env, 1), known[1].solution).reward
    ok = success > max(*usual, failed) + 1e-9 and failed <= max(usual) + 1e-9
    return Finding("rewards", ok, expected, f"a step {max(usual):g}, a failed Done {failed:g}, success {success:g}")


def figures(subject: Subject) -> Finding:
    """``episode_metrics`` and ``is_success`` come at the end only and are those of the steps taken.

    Compared with the environment without a wrapper over four action sequences.
    """
    expected = "true steps, moves, opens, collisions and success, SPL by its formula, only at the end"
    env, ours, known = subject.make(), subject.reference(), subject.episodes()
    plans = [known[1].solution, "2206", "0" * 20 + "3540" + "6", "00100200050000026"]
    for plan in plans:
        seen, right = reset(env, 1), reset(ours, 1)
        for digit in plan:
            early = "episode_metrics" in seen.info or "is_success" in seen.info
            seen, right = step(env, int(digit)), step(ours, int(digit))
            if early:
                return Finding("figures", False, expected, "some before the end")
        wanted = {**right.info["episode_metrics"], "is_success": right.info["is_success"]}
        told = {**seen.info.get("episode_metrics", {}), "is_success": seen.info.get("is_success")}
        wrong = [name for name, value in wanted.items() if told.get(name) != value]
        if wrong:
            found = f"{wrong[0]} {told.get(wrong[0])!r}, instead of {wanted[wrong[0]]!r}"
            return Finding("figures", False, expected, found)
    return Finding("figures", True, expected, f"as expected in {len(plans)} episodes")


def figures_of_choices(subject: Subject) -> Finding:
    """``episode_metrics`` of an episode of choices are those of its primitive steps."""
    expected = "true steps, path and success, SPL by its formula, only at the end"
    env = subject.make()
    for episode in (0, 1):
        seen, number = reset(env, episode), 0
        while not seen.over and number < 400:
            if "episode_metrics" in seen.info or "is_success" in seen.info:
                break
            seen, number = step(env, choice(seen, number)), number + 1
        told = dict(seen.info.get("episode_metrics", {}))
        ledger: Any = core(env).ledger
        right = ledger.outcome().to_json()
        wrong = [name for name in right if told.get(name) != right[name]]
        if not seen.over or wrong or seen.info.get("is_success") is not bool(right["success"]):
            name = wrong[0] if wrong else "is_success"
            return Finding("figures", False, expected, f"{name} {told.get(name)!r}, instead of {right.get(name)!r}")
    return Finding("figures", True, expected, "as expected in 2 episodes")


def image_goal(subject: Subject) -> Finding:
    """Done away from the goal of an image-goal episode ends it without success."""
    expected = "Done away from the goal ends the episode without success"
    env = subject.make()
    early = to_the_end(subject, env, reset(env, 0))
    found = (early.terminated, _success(early), early.info["episode_metrics"]["steps"])
    return Finding("done", found == (True, False, 4), expected, f"terminated, success, steps: {found}")


def _solved(env: Env, seen: Step, solution: str) -> Step:
    """Play a solution (digits) to its end, and return the last result."""
    for digit in solution:
        if seen.over:
            break
        seen = step(env, int(digit))
    return seen


def _success(seen: Step) -> bool:
    """Whether both the metrics and ``is_success`` of the last result say that the episode succeeded."""
    return bool(seen.info.get("episode_metrics", {}).get("success")) and seen.info.get("is_success") is not False
