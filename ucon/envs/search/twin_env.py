"""``UcONSearch-v0`` with a hidden target, for trainers: how would the search score if the target lay elsewhere?"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.search.twins import Twins
from ucon.envs.ucon_env import Obs
from ucon.perception.belief.from_habits import expecting
from ucon.perception.belief.target_belief import KNOWN_HOME, TargetBelief
from ucon.perception.mapping.semantic_map import frame_depth
from ucon.perception.places.sight import Sight
from ucon.search.beyond import MOVES
from ucon.task.actions import Action


class TwinSearchEnv(UcONSearchEnv):
    """Searches to the last step, and rewards every place at which a target would have been found.

    The target is hidden from the detector. The reward of a choice is the expected SPL of the targets that its frames
    would have shown for the first time (:mod:`ucon.envs.search.twins`); averaged over episodes, the sum of the rewards
    is the SPL. Everything else is as in :class:`ucon.envs.search.env.UcONSearchEnv`.
    """

    _shared: ClassVar[frozenset[str]] = UcONSearchEnv._shared | {"_one_look"}
    _twins: Twins | None = None
    _earned = 0.0

    @property
    def twins(self) -> Twins:
        """The places where the target might be, after a reset. Privileged.

        Raises:
            EpisodeError: before the first reset.
        """
        if self._twins is None:
            raise EpisodeError("no twins before the first reset: call reset() first")
        return self._twins

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start an episode without its target; see :meth:`ucon.envs.search.env.UcONSearchEnv.reset`."""
        self._twins, self._earned = None, 0.0
        return super().reset(seed=seed, options={**(options or {}), "hide_target": True})

    def beyond(self) -> NDArray[np.float32]:
        """Share of the targets not found yet that could be found within :data:`ucon.search.beyond.MOVES` of each view.

        Returns:
            (V, R) float32; 0 in rows without a view.

        Raises:
            EpisodeError: no choice is due.
        """
        self._course.require("beyond")
        if self._tokens is None:
            raise EpisodeError("beyond without a choice to make: the episode is over, call reset() first")
        views = [choice.view for choice in self._tokens.choices]
        out = np.zeros((self._sizes.views, len(MOVES)), np.float32)
        out[: len(views)] = self.twins.within(views, MOVES)
        return out

    def go_on(self, row: int, steps: int) -> tuple[float, float, float]:
        """Make one choice, then continue the search by gain over cost, without further choices by the agent.

        Args:
            row: row of the chosen view.
            steps: number of actions, counted from now. The environment cannot be used afterwards.

        Returns:
            Expected SPL of the targets found on the way, the probability that the target would not have been found
            yet, and the share of the episode's steps that are left; 0 if the search has ended.

        Raises:
            EpisodeError: no choice is due.
        """
        self._course.require("go_on")
        if self._tokens is None or self._searcher is None:
            raise EpisodeError("go_on without a choice to make: the episode is over, call reset() first")
        searcher, began = self._searcher, self.env.ledger.steps
        action: Action | None = searcher.choose(self._tokens.choices[row])
        self._earned, self._tokens = 0.0, None
        while self.env.ledger.steps < began + steps:
            if action is not None:
                obs, _, *over, info = self.env.step(int(action))
                self._last, self._over = (obs, info), (over[0], over[1])
                if any(over):
                    break
            action = self._look()
            if action is None:
                action = searcher.choose(searcher.decision().best)
        left = 0.0 if any(self._over) else 1.0 - self.env.ledger.steps / self.env.rules.max_steps
        return self._earned, self.twins.left, left

    def _look(self) -> Action | None:
        """Take in the newest frame, and earn the expected SPL of the twins that it would have shown."""
        action, searcher = super()._look(), self._searcher
        assert searcher is not None
        if self._twins is None:
            self._twins = self._made()
        ledger, depth = self.env.ledger, frame_depth(*self._last)
        self._earned += self._twins.see(self.env, searcher.map, depth, ledger.moves, ledger.steps, self._one_look)
        return action

    def _reward(self, info: dict[str, Any]) -> float:
        """The expected SPL of what was found since the last choice."""
        earned, self._earned = self._earned, 0.0
        return earned

    def _made(self) -> Twins:
        """Twins of the episode that has just begun."""
        assert self._searcher is not None
        info, places = self._last[1], self._searcher.places
        errors = info.get("detector_errors")
        self._one_look = None if errors is None else Sight.of(errors, self._searcher.target, passes=1.0)

        def believing() -> TargetBelief:
            return expecting(info, self._locate, weights=KNOWN_HOME, locations=self._locations)

        return Twins(self.env, believing, places.target_height_m, self._searcher.viewpoints.reach_m)
