"""How much a collection plays and where its episodes begin, whatever is learned from it."""

from __future__ import annotations

from dataclasses import dataclass

from ucon.core.errors import ConfigError, brief


@dataclass(frozen=True)
class Rollouts:
    """Size of a collection, and where its episodes begin and are cut off.

    Raises:
        ConfigError: a number out of range.
    """

    episodes: int = 200
    """Episodes of one collection."""
    max_steps: int = 200
    """Episodes are cut off after this many actions."""
    slots: int = 20
    """Episodes played at once, by one process."""
    backplay: float = 0.0
    """Share of episodes that begin along their stored solution, near its end (Backplay: Resnick et al. 2018). Reactive
    policies see the target in few frames of a whole search and hardly ever succeed; from there they do."""
    backplay_steps: int = 30
    """Most steps of the solution that are left then; the number is drawn."""

    def __post_init__(self) -> None:
        self.require_counts("episodes", "max_steps", "slots", "backplay_steps")
        self.require_shares("backplay")

    def require_counts(self, *names: str) -> None:
        """Refuse options that are no whole number from 1 up."""
        for name in names:
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be a whole number from 1 up")

    def require_shares(self, *names: str) -> None:
        """Refuse options that are no number from 0 to 1."""
        for name in names:
            value = getattr(self, name)
            if type(value) not in (int, float) or not 0 <= value <= 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be from 0 to 1")
