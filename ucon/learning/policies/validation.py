"""How checkpoints of a policy are compared: by loss on expert demonstrations, and by its own SR and SPL."""

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

#: Figures that may choose the best checkpoint, with +1 where more is better and -1 where less is.
SCORES = {"loss": -1.0, "accuracy": 1.0, "success_rate": 1.0, "spl": 1.0}
#: Figures that need the policy to play.
_PLAYED = ("success_rate", "spl")
#: Weight of the loss in the score. It only breaks ties: one episode in a thousand changes SR by more.
_TIE = 1e-5


@dataclass(frozen=True)
class Validation:
    """Which validation episodes are used, how they are played, and which figure chooses the best checkpoint.

    Raises:
        ConfigError: a number out of range, an unknown level or figure, or a figure that needs play with ``n_play=0``.
    """

    episodes: str = "val"
    """A named set or a file. Evenly spaced episodes are taken: the first ones would all be in one kind of home."""
    n_demonstrations: int = 64
    """Number of demonstrations on which loss and accuracy are measured."""
    n_play: int = 40
    """Number of episodes that the policy plays; 0 plays none."""
    level: str = "retrieval"
    """Habit level of the played episodes."""
    max_steps: int = 300
    """Played episodes are cut off after this many actions, and then count as failed."""
    slots: int = 20
    """Episodes played in parallel."""
    sample: bool = False
    """True: sample actions from the policy's probabilities. False: take the highest logit."""
    temperature: float = 1.0
    """Logits are divided by it before an action is sampled; best as in play."""
    choose: str = "spl"
    """Figure that chooses the best checkpoint: loss, accuracy, success_rate or spl."""

    def __post_init__(self) -> None:
        for name, least in (("n_demonstrations", 1), ("n_play", 0), ("max_steps", 1), ("slots", 1)):
            value = getattr(self, name)
            if type(value) is not int or value < least:
                raise ConfigError(f"learner.validation.{name}={brief(value)}: must be a whole number from {least} up")
        if type(self.temperature) not in (int, float) or not 0.01 <= self.temperature <= 100:
            raise ConfigError(f"learner.validation.temperature={brief(self.temperature)}: must be from 0.01 to 100")
        if self.choose not in SCORES:
            raise ConfigError(unknown_name("figure of learner.validation.choose", str(self.choose), SCORES))
        if self.choose in _PLAYED and not self.n_play:
            raise ConfigError(
                f"learner.validation.choose={self.choose} with n_play=0: nothing is played; choose loss or accuracy"
            )
        check_level(self.level)

    @cached_property
    def all(self) -> tuple[Episode, ...]:
        """All episodes of the set, before any are picked; loaded on first use."""
        return load_episodes(self.episodes)

    def demonstrations(self, levels: Sequence[str]) -> list[Trajectory]:
        """Demonstrations on which loss and accuracy are measured.

        Args:
            levels: habit levels, which take turns.
        """
        chosen = evenly_spaced(self.all, self.n_demonstrations, "learner.validation.n_demonstrations")
        return [demonstration(episode, levels[k % len(levels)]) for k, episode in enumerate(chosen)]

    def played(self, players: Players, seed: int) -> Figures:
        """Play validation episodes with the policy.

        Args:
            players: environments with the policy.
            seed: of sampled actions.

        Returns:
            ``success_rate``, ``spl`` and ``steps`` (mean number of actions); empty where ``n_play`` is 0.
        """
        if not self.n_play:
            return {}
        chosen = evenly_spaced(self.all, self.n_play, "learner.validation.n_play")
        chooser = PolicyChooser(self.sample, seed, "validation", temperature=self.temperature)
        results = players.play([Job(e, self.level) for e in chosen], chooser, "validating")
        return {
            "success_rate": sum(r.success for r in results) / len(results),
            "spl": sum(r.spl for r in results) / len(results),
            "steps": sum(len(r.actions) for r in results) / len(results),
        }

    def score(self, figures: Figures) -> Figures:
        """The ``score`` that chooses the best checkpoint, larger is better.

        Among equal figures, such as those of untrained policies, the smaller loss wins.
        """
        return {SCORE: SCORES[self.choose] * figures[self.choose] - _TIE * figures["loss"]}


def evenly_spaced(episodes: Sequence[Episode], count: int | None, option: str) -> tuple[Episode, ...]:
    """``count`` evenly spaced episodes of a list, so that every kind of home is among them; None: all.

    Args:
        episodes: to pick from, in order.
        count: how many.
        option: name of the configuration's option, for the error.

    Raises:
        ConfigError: ``count`` is not a whole number from 1 to the number of episodes.
    """
    if count is None:
        return tuple(episodes)
    if type(count) is not int or not 1 <= count <= len(episodes):
        raise ConfigError(f"{option}={brief(count)}: expected a whole number from 1 to {len(episodes)}")
    return tuple(episodes[k * len(episodes) // count] for k in range(count))
