"""How states of a policy are compared while it learns: against the expert's steps, and by what it does by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ucon.core.errors import ConfigError, brief, unknown_name
from ucon.learning.imitation.trajectories import Trajectory, demonstration
from ucon.learning.policies.playing import Job, Players, PolicyChooser
from ucon.learning.run.protocol import Figures
from ucon.learning.run.trainer_state import SCORE
from ucon.retrieval.levels import check_level
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

#: Figures that may choose the best state, and whether more is better.
SCORES = {"loss": -1.0, "accuracy": 1.0, "success_rate": 1.0, "spl": 1.0}
#: Those that are known only if the policy plays.
_PLAYED = ("success_rate", "spl")
#: So little that it decides among equals alone: one episode in a thousand is more.
_TIE = 1e-5


@dataclass(frozen=True)
class Validation:
    """Validation episodes, and what is done with them.

    Raises:
        ConfigError: a number out of range, an unknown level or figure, or a figure that nothing gives.
    """

    episodes: str = "val"
    """A named set or a file; its first episodes would be of one kind, so they are taken evenly spaced."""
    n_demonstrations: int = 64
    """For loss and accuracy."""
    n_play: int = 40
    """That the policy plays; 0: none."""
    level: str = "retrieval"
    """Habit level at which it plays."""
    max_steps: int = 300
    """Played episodes are cut short here, and have failed."""
    slots: int = 20
    """Episodes played at once."""
    sample: bool = False
    """Draw actions by their probabilities in place of the best."""
    choose: str = "spl"
    """The figure that chooses the best state: loss, accuracy, success_rate or spl."""

    def __post_init__(self) -> None:
        for name, least in (("n_demonstrations", 1), ("n_play", 0), ("max_steps", 1), ("slots", 1)):
            value = getattr(self, name)
            if type(value) is not int or value < least:
                raise ConfigError(f"learner.validation.{name}={brief(value)}: must be a whole number from {least} up")
        if self.choose not in SCORES:
            raise ConfigError(unknown_name("figure of learner.validation.choose", str(self.choose), SCORES))
        if self.choose in _PLAYED and not self.n_play:
            raise ConfigError(
                f"learner.validation.choose={self.choose} with n_play=0: nothing is played; choose loss or accuracy"
            )
        check_level(self.level)

    @cached_property
    def all(self) -> tuple[Episode, ...]:
        """The episodes that these are chosen from."""
        return load_episodes(self.episodes)

    def demonstrations(self, levels: Sequence[str]) -> list[Trajectory]:
        """What loss and accuracy are measured on: the levels in turn."""
        chosen = spaced(self.all, self.n_demonstrations, "learner.validation.n_demonstrations")
        return [demonstration(episode, levels[k % len(levels)]) for k, episode in enumerate(chosen)]

    def played(self, players: Players, seed: int) -> Figures:
        """SR and SPL of the policy, and how many steps it takes; nothing where nothing is to be played."""
        if not self.n_play:
            return {}
        chosen = spaced(self.all, self.n_play, "learner.validation.n_play")
        results = players.play(
            [Job(e, self.level) for e in chosen], PolicyChooser(self.sample, seed, "validation"), "validating"
        )
        return {
            "success_rate": sum(r.success for r in results) / len(results),
            "spl": sum(r.spl for r in results) / len(results),
            "steps": sum(len(r.actions) for r in results) / len(results),
        }

    def score(self, figures: Figures) -> Figures:
        """The figure that chooses, larger is better; among equals, such as untrained policies, the smaller loss."""
        return {SCORE: SCORES[self.choose] * figures[self.choose] - _TIE * figures["loss"]}


def spaced(episodes: Sequence[Episode], count: int | None, option: str) -> tuple[Episode, ...]:
    """So many episodes, evenly spaced, so that every kind of home is among them; None: all.

    Raises:
        ConfigError: no such number.
    """
    if count is None:
        return tuple(episodes)
    if type(count) is not int or not 1 <= count <= len(episodes):
        raise ConfigError(f"{option}={brief(count)}: expected a whole number from 1 to {len(episodes)}")
    return tuple(episodes[k * len(episodes) // count] for k in range(count))
