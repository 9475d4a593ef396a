"""The metrics of one episode, and the cause of a failure."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

FailureCause = Literal[
    "none", "never_seen", "seen_not_reached", "container_never_opened", "stopped_early", "out_of_steps"
]


@dataclass(frozen=True)
class EpisodeOutcome:
    """The deterministic metrics of one finished episode."""

    success: bool
    """Whether Done was called with the target in view and within reach."""
    steps: int
    """Actions taken."""
    path_length_m: float
    """Metres moved; the p of SPL."""
    shortest_path_m: float
    """Length of the shortest solution, metres; the l of SPL."""
    final_distance_m: float
    """Path length from the agent's last node to the end of the stored solution, metres."""
    start_distance_m: float
    """Path length from the start to the end of the stored solution, metres."""
    opens: int
    """Open actions."""
    containers_opened: int
    """Containers that these actions opened."""
    collisions: int
    """Blocked moves."""
    first_seen_step: int
    """Step after which the target was first visible (0: from the start); -1: never."""
    stopped: bool
    """Whether Done was called."""
    in_reach: bool
    """Whether Done would have succeeded at some step."""
    contained: bool
    """Whether the target was behind a closed door."""
    container_opened: bool
    """Whether that door was opened."""

    @property
    def spl(self) -> float:
        """Success weighted by path length: S * l / max(p, l), in [0, 1]."""
        return self._path_ratio if self.success else 0.0

    @property
    def soft_spl(self) -> float:
        """SPL with success replaced by the share of the start distance that was covered, in [0, 1]."""
        closed = 1.0 if self.success else max(0.0, 1.0 - self.final_distance_m / max(self.start_distance_m, 1e-9))
        return closed * self._path_ratio

    @property
    def failure_cause(self) -> FailureCause:
        """Why the episode failed; ``none`` for a success.

        ``out_of_steps``: Done would have succeeded at some step but was never called.
        """
        if self.success:
            return "none"
        if self.stopped:
            return "stopped_early"
        if self.contained and not self.container_opened:
            return "container_never_opened"
        if self.first_seen_step < 0:
            return "never_seen"
        return "out_of_steps" if self.in_reach else "seen_not_reached"

    def to_json(self) -> dict[str, Any]:
        """All fields, with ``spl``, ``soft_spl`` and ``failure_cause``."""
        derived = {"spl": self.spl, "soft_spl": self.soft_spl, "failure_cause": self.failure_cause}
        return asdict(self) | derived

    @property
    def _path_ratio(self) -> float:
        """Shortest path over the longer of both paths: l / max(p, l)."""
        return self.shortest_path_m / max(self.path_length_m, self.shortest_path_m, 1e-9)
