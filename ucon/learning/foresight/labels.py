"""Labels of foresight: the remaining way to the target from every view of every decision of a search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ucon.learning.decisions.decisions import TEXT, Arrays, Decisions, by_gain_over_cost, joined
from ucon.task.episode import Episode


@dataclass(frozen=True)
class WaysToTarget:
    """Implements :class:`ucon.learning.decisions.store.Labels`."""

    name: ClassVar[str] = "foresight"
    label: ClassVar[str] = "distance_to_goal"
    searches: ClassVar[int] = 20
    code: ClassVar[tuple[str, ...]] = ("learning/foresight/labels.py",)

    def __call__(self, env: Any, episode: Episode, level: str, draw: np.random.Generator) -> Decisions | None:
        """Search one episode by gain over cost, the policy that an untrained ``habit_policy`` plays.

        Args:
            env: of ``UcONSearch-v0``, with ``distance_to_goal=True``.
            episode: of a training home.
            level: habit level.
            draw: not used.

        Returns:
            Its decisions; None where nothing was to be decided.
        """
        kept: list[Arrays] = []
        observation, _ = env.reset(options={"episode": episode, "habit_level": level})
        text, over = observation, not observation["action_mask"][1:].any()
        while not over:
            kept.append({name: value for name, value in observation.items() if name not in TEXT})
            observation, _, terminated, truncated, _ = env.step(by_gain_over_cost(observation))
            over = terminated or truncated
        return joined(kept, text)
