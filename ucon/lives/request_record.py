"""What the record of a request has besides an episode's: when the request was, and what the robot could know."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class LifeFacts:
    """One request within a life. Privileged, for tables only."""

    life: str
    """Id of the life."""
    request: int
    """Number of the request in the life, from 0."""
    day: int
    """Day of the life, from 0."""
    slot: int
    """0: morning, 1: midday, 2: evening."""
    seen_days_ago: float | None
    """Days since the robot last saw the thing, in thirds (slots); None: never."""
    moved: bool | None
    """Whether the thing is now elsewhere than where the robot last saw it; None: never seen."""
    obeys: bool
    """Whether a sentence given to the agent supports the place where the thing is."""
    changed: bool
    """Whether the habits of the thing have changed."""

    def to_json(self) -> dict[str, Any]:
        """The facts as JSON data."""
        return asdict(self)


@dataclass(frozen=True)
class BelievedPlace:
    """One place where a robot believed a thing to be, before it went to look."""

    words: str
    """The place in words, such as ``on the countertop, beside the sink``; "" if the robot cannot name it."""
    p: float
    """Its probability."""
    x: float
    """Metres ahead of the dock."""
    y: float
    """Metres to the left of the dock."""
    z: float
    """Metres above the floor."""
