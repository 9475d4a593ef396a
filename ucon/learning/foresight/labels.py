"""Labels of foresight: what lies beyond each view of a decision, computed from twins of the episode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from ucon.learning.decisions.decisions import TEXT, Arrays, Decisions, by_gain_over_cost, joined
from ucon.learning.run.option_checks import check
from ucon.task.episode import Episode

#: A search ends when the target is still unfound with less than this probability: choices hardly matter any more.
LEAST_LEFT: Final = 0.03


@dataclass(frozen=True)
class Beyond:
    """Implements :class:`ucon.learning.decisions.store.Labels`.

    Attributes:
        share: of the decisions of a search that are labelled; neighbouring ones are much alike.
    """

    share: float = 0.5

    name: ClassVar[str] = "foresight"
    label: ClassVar[str] = "beyond"
    searches: ClassVar[int] = 8
    code: ClassVar[tuple[str, ...]] = ("learning/foresight/labels.py", "envs/tour.py")

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            ConfigError: one of a wrong type or out of range.
        """
        check("above 0, at most 1", lambda x: 0 < x <= 1, (int, float), **{"beyond.share": self.share})

    def __call__(self, env: Any, episode: Episode, level: str, draw: np.random.Generator) -> Decisions | None:
        """Search one episode by gain over cost, as an untrained ``habit_policy`` does, and label some decisions.

        Args:
            env: an environment of :class:`ucon.envs.search.twin_env.TwinSearchEnv`.
            episode: of a training home.
            level: habit level.
            draw: random numbers of this search.

        Returns:
            Labelled decisions; None where there are none. ``beyond`` (n, V, R) is the share of the target's remaining
            probability that lies within each of R numbers of moves from each view.
        """
        kept: list[Arrays] = []
        observation, _ = env.reset(options={"episode": episode, "habit_level": level})
        text, over = observation, not observation["action_mask"][1:].any()
        while not over and env.twins.left > LEAST_LEFT:
            if draw.random() < self.share:
                kept.append(frames_of(observation) | {self.label: env.beyond()})
            observation, _, terminated, truncated, _ = env.step(by_gain_over_cost(observation))
            over = terminated or truncated
        return joined(kept, text)


def frames_of(observation: Arrays) -> Arrays:
    """An observation of ``UcONSearch-v0`` without its text."""
    return {name: value for name, value in observation.items() if name not in TEXT}
