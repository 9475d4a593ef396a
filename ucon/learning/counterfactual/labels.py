"""Labels of counterfactual rollouts: what would going to other views have led to?

At some decisions of a search, copies of the search choose each of several views, and from the next decision on, some
steps later, they search by gain over cost: rollout policy improvement (Bertsekas). So the worth of a choice is its
worth to a search that may change its mind at the next decision. Finds are counted for targets all over the home
(:mod:`ucon.envs.search.twins`), so that differences between views do not depend on where one target happens to lie.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.learning.decisions.decisions import Arrays, Decisions, by_gain_over_cost, joined, rivals
from ucon.learning.foresight.labels import LEAST_LEFT, Beyond, frames_of
from ucon.learning.run.option_checks import check
from ucon.task.episode import Episode


@dataclass(frozen=True)
class Rollouts:
    """Implements :class:`ucon.learning.decisions.store.Labels`.

    Attributes:
        share: of the decisions of a search that are labelled.
        views: how many views are tried from each: the one that gain over cost chooses, and others drawn from its
            rivals.
        steps: length of a rollout. Longer ones cost more and tell views apart no better: at 45 to 60 steps the order by
            gain over cost stands out from the noise as far as it does in whole searches.
        rest: SPL of what is found after a rollout, relative to the share of the steps that is left then. The same order
            stands out most at .4 to .5.
    """

    share: float = 0.2
    views: int = 6
    steps: int = 60
    rest: float = 0.4

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            ConfigError: one of a wrong type or out of range.
        """
        check("above 0, at most 1", lambda x: 0 < x <= 1, (int, float), **{"rollouts.share": self.share})
        check("2 or more and whole", lambda x: x >= 2, (int,), **{"rollouts.views": self.views})
        check("1 or more and whole", lambda x: x >= 1, (int,), **{"rollouts.steps": self.steps})
        check("from 0 to 1", lambda x: 0 <= x <= 1, (int, float), **{"rollouts.rest": self.rest})

    name: ClassVar[str] = "counterfactual"
    label: ClassVar[str] = "worth"
    searches: ClassVar[int] = 8
    code: ClassVar[tuple[str, ...]] = ("learning/counterfactual/labels.py", *Beyond.code)

    def __call__(self, env: Any, episode: Episode, level: str, draw: np.random.Generator) -> Decisions | None:
        """Search one episode by gain over cost, and label some of its decisions.

        Args:
            env: an environment of :class:`ucon.envs.search.twin_env.TwinSearchEnv`.
            episode: of a training home.
            level: habit level.
            draw: random numbers of this search.

        Returns:
            Labelled decisions; None where there are none. ``worth`` (n, V) float32 is the expected SPL from there on of
            choosing each view, nan for views that were not tried; ``beyond`` is that of
            :class:`ucon.learning.foresight.labels.Beyond`.
        """
        kept: list[Arrays] = []
        observation, _ = env.reset(options={"episode": episode, "habit_level": level})
        text, over = observation, not observation["action_mask"][1:].any()
        while not over and env.twins.left > LEAST_LEFT:
            among = rivals(observation)
            if draw.random() < self.share and among.sum() > 1:
                told = {Beyond.label: env.beyond(), self.label: self._worth(env, observation, among, draw)}
                kept.append(frames_of(observation) | told)
            observation, _, terminated, truncated, _ = env.step(by_gain_over_cost(observation))
            over = terminated or truncated
        return joined(kept, text)

    def _worth(
        self, env: Any, observation: Arrays, among: NDArray[np.bool_], draw: np.random.Generator
    ) -> NDArray[np.float32]:
        """Expected SPL from here on of choosing each view that is tried, (V,) float32; nan for the others."""
        order = np.where(among, draw.random(len(among)), -1.0)
        order[by_gain_over_cost(observation)] = 2.0
        worth = np.full(len(among), np.nan, np.float32)
        for row in np.argsort(-order)[: min(self.views, int(among.sum()))]:
            earned, left, steps_left = deepcopy(env).go_on(int(row), self.steps)
            worth[row] = earned + self.rest * left * steps_left
        return worth
