"""Checks of what the agent senses: pose, collisions, its last action, and the camera's images."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from ucon.envs.checking.findings import Finding
from ucon.envs.checking.subject import Step, Subject, core, reset, step
from ucon.task.actions import Action, decoded_action

#: Actions that go through all headings and pitches and include blocked moves.
_TOUR: Final = (0, 0, 2, 0, 0, 3, 0, 2, 0, 4, 4, 0, 2, 0, 0, 1, 0, *(0,) * 12, 2, *(0,) * 12)
#: Largest mean difference from the reference image, in metres and in colour levels; images of other sizes differ.
_DEPTH_M, _COLOUR = 0.15, 12.0


def _walked(subject: Subject) -> Iterator[tuple[int, Step, Step, Any]]:
    """Walk both environments; yields the action, both results (subject, reference) and the reference's core."""
    for episode in (0, 1):
        env, ours = subject.make(), subject.reference()
        truth = core(ours)
        seen, reference = reset(env, episode), reset(ours, episode)
        yield -1, seen, reference, truth
        for action in _TOUR:
            seen, reference = step(env, action), step(ours, action)
            yield action, seen, reference, truth


def frame(subject: Subject) -> Finding:
    """``pose`` is relative to the start: x ahead, y left, yaw to the left, pitch up, in metres and radians."""
    x = y = yaw = pitch = 0.0
    expected = "(x ahead, y left, yaw left, pitch up) relative to the start, in metres and radians"
    for number, (action, seen, reference, truth) in enumerate(_walked(subject)):
        if action < 0:
            x = y = yaw = pitch = 0.0
        elif truth.rules.continuous:  # even a blocked move may go part of the way
            x, y, yaw, pitch = np.asarray(reference.obs["pose"], float).tolist()
        elif action == Action.MOVE_AHEAD and not reference.obs["collision"]:
            x, y = x + 0.25 * np.cos(yaw), y + 0.25 * np.sin(yaw)
        elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            yaw += np.pi / 2 * (1 if action == Action.ROTATE_LEFT else -1)
        elif action in (Action.LOOK_UP, Action.LOOK_DOWN) and not truth.rules.look_moves_camera:
            most = np.radians(truth.rules.max_pitch_deg)
            pitch = float(np.clip(pitch + np.radians(30) * (1 if action == Action.LOOK_UP else -1), -most, most))
        told = np.asarray(seen.obs["pose"], float)
        turned = (told[2] - yaw + np.pi) % (2 * np.pi) - np.pi
        if np.abs([told[0] - x, told[1] - y, turned, told[3] - pitch]).max() > 1e-3:
            right = ", ".join(f"{v:.2f}" for v in (x, y, yaw, pitch))
            found = f"({', '.join(f'{v:.2f}' for v in told)}) at step {number}, instead of ({right})"
            return Finding("frame", False, expected, found)
    return Finding("frame", True, expected, "as expected at all steps")


def touch(subject: Subject) -> Finding:
    """``collision`` is 1 exactly where the last move was blocked."""
    blocked, expected = 0, "1 where the last move was blocked, else 0"
    for number, (_, seen, reference, _truth) in enumerate(_walked(subject)):
        told, right = int(seen.obs["collision"][0]), int(reference.obs["collision"][0])
        blocked += right
        if told != right:
            found = f"{told} at step {number}, instead of {right}"
            return Finding("collision", False, expected, found)
    return Finding("collision", True, expected, f"as expected, {blocked} moves were blocked")


def memory(subject: Subject) -> Finding:
    """``last_action`` and ``step`` belong to the step that was just taken; zeros at the reset."""
    taken, expected = 0, "the action and the number of the step just taken, 7 (none) and 0 at reset"
    for action, seen, _, _truth in _walked(subject):
        taken = 0 if action < 0 else taken + 1
        wanted = (len(Action) if action < 0 else action, taken)
        found = (decoded_action(seen.obs["last_action"]), int(seen.obs["step"][0]))
        if found != wanted:
            return Finding("last action, step", False, expected, f"{found}, instead of {wanted}")
    return Finding("last action, step", True, expected, "as expected at all steps")


def camera(subject: Subject) -> Finding:
    """``depth`` is in metres along the optical axis and ``rgb`` in its true colours, both of the current frame."""
    expected = "depth in metres and colours of the current frame"
    looked = 0
    for number, (_, seen, reference, _truth) in enumerate(_walked(subject)):
        for name, most in (("depth", _DEPTH_M), ("rgb", _COLOUR)):
            if name not in seen.obs or name not in reference.obs:
                continue
            looked += 1
            told, right = (np.asarray(s.obs[name], float) for s in (seen, reference))
            apart = float(np.abs(told - right).mean()) if told.shape == right.shape else abs(told.mean() - right.mean())
            if apart > most:
                found = f"{name} of mean {told.mean():.2f} at step {number}, instead of {right.mean():.2f}"
                return Finding("camera", False, expected, f"{found}, {apart:.2f} off per pixel")
    return Finding(
        "camera", True, expected, f"as expected in {looked} images" if looked else "no images (observe=symbolic)"
    )
