"""The seven actions, in the paper's order."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class Action(IntEnum):
    """What the agent can do in one step (paper, section III)."""

    MOVE_AHEAD = 0
    """0.25 m along the heading; a blocked move costs the step and raises the collision flag."""
    ROTATE_RIGHT = 1
    """90 degrees clockwise."""
    ROTATE_LEFT = 2
    """90 degrees counter-clockwise."""
    LOOK_UP = 3
    """30 degrees, up to +60."""
    LOOK_DOWN = 4
    """30 degrees, down to -60."""
    OPEN = 5
    """Open every closed openable object that is visible and near."""
    DONE = 6
    """End the episode; success if the target is visible and near."""


#: Step of a MoveAhead as (di, dj) in nodes, at headings 0, 90, 180, 270 degrees.
AHEAD = ((1, 0), (0, 1), (-1, 0), (0, -1))
NO_ACTION = len(Action)
"""Stands for the last action at the start of an episode, before any action was taken."""


def encoded_action(action: int) -> NDArray[np.int8]:
    """One-hot ``last_action`` of an observation, (7,) int8; zeros for :data:`NO_ACTION`."""
    code = np.zeros(len(Action), np.int8)
    code[action:][:1] = 1
    return code


def decoded_action(code: NDArray[np.int8]) -> int:
    """The action that a ``last_action``, (7,) int8, encodes; :data:`NO_ACTION` for zeros."""
    return int(code.argmax()) if code.any() else NO_ACTION
