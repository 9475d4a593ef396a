"""The seven actions, in the paper's order."""

from __future__ import annotations

from enum import IntEnum


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


#: (di, dj) in nodes of a MoveAhead at headings 0, 90, 180, 270 degrees.
AHEAD = ((1, 0), (0, 1), (-1, 0), (0, -1))
