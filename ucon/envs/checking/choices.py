"""Checks of the action masks: which actions may be chosen, and what an invalid choice costs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.envs.checking.findings import Finding
from ucon.envs.checking.subject import Subject, choice, core, reset, step


def masks(subject: Subject) -> Finding:
    """``action_mask`` is 1 for rows that can be chosen and 0 for others, and ``action_masks()`` says the same.

    Any other row takes one step and sets ``info["invalid"]``. For environments whose action is a view.
    """
    expected = "1 for the rows that action_masks() allows; any other row takes one step"
    env = subject.make()
    for episode in (0, 1):
        seen = reset(env, episode)
        for number in range(3):
            if seen.over:
                break
            mask = np.asarray(seen.obs["action_mask"]) == 1
            inner: Any = env.unwrapped
            asked: Any = env.get_wrapper_attr("action_masks")()
            if not mask.any() or not np.array_equal(mask, inner.action_masks()) or not np.array_equal(asked, mask):
                found = f"{int(mask.sum())} rows set, but {int(inner.action_masks().sum())} may be chosen"
                return Finding("masks", False, expected, found)
            seen = step(env, choice(seen, number))
            if seen.info["invalid"]:
                return Finding("masks", False, expected, "a row whose mask is 1 was invalid")
        if not seen.over and not seen.obs["action_mask"].all():
            before = core(env).ledger.steps
            seen = step(env, int(np.flatnonzero(seen.obs["action_mask"] == 0)[0]))
            spent = core(env)._ledger.steps - before  # type: ignore[union-attr]
            if not seen.info["invalid"] or spent < 1:
                return Finding("masks", False, expected, f"a row whose mask is 0 was accepted, for {spent} steps")
    return Finding("masks", True, expected, "as expected")


def all_actions(subject: Subject) -> Finding:
    """``action_masks()`` allows all seven actions, since masks must not tell what an action would do."""
    env = subject.make()
    reset(env, 0)
    asked = np.asarray(env.get_wrapper_attr("action_masks")())
    ok = asked.dtype == bool and asked.tolist() == [True] * 7
    return Finding("masks", ok, "action_masks() that allows all seven", f"{asked.astype(int).tolist()}")
