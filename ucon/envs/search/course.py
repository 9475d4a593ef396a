"""The course of an episode of choices: whether a step may be taken, and the frames between two choices."""

from __future__ import annotations

from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.core.sharing import PartlyShared
from ucon.envs.options import check_render_mode
from ucon.envs.painter import Moment
from ucon.envs.ucon_env import UcONEnv

RENDER_MODES: Final = ["rgb_array", "rgb_array_list"]


class Course(PartlyShared):
    """Whether an episode has begun or ended, as seen by the agent that chooses, and the episode's frames."""

    _flat = frozenset({"_moments"})

    def __init__(self, render_mode: str | None) -> None:
        """Start without an episode.

        Args:
            render_mode: None, ``rgb_array`` or ``rgb_array_list``.

        Raises:
            ConfigError: another mode.
        """
        check_render_mode(render_mode, RENDER_MODES)
        self._mode = render_mode
        self._begun = self._over = False
        self._moments: list[Moment] = []

    def begin(self, env: UcONEnv) -> None:
        """Note that an episode has begun in ``env``."""
        self._begun, self._over = True, False
        self._moments.clear()
        self.note(env)

    def note(self, env: UcONEnv) -> None:
        """Note that a primitive step was taken; with ``rgb_array_list`` its frame will be drawn on demand."""
        if self._mode == "rgb_array_list":
            self._moments.append(cast(UcONEnv, env.unwrapped).moment())

    def note_over(self, *, over: bool) -> None:
        """Note whether the last result said that the episode is over."""
        self._over = over

    def close(self) -> None:
        """Forget the episode: the environment was closed, or a reset is under way."""
        self._begun = False
        self._moments.clear()

    def require(self, what: str) -> None:
        """Check that there is an episode.

        Raises:
            EpisodeError: there is none; ``what`` names the call.
        """
        if not self._begun:
            raise EpisodeError(f"{what} before reset, or after close: call reset() first")

    def require_open(self, what: str) -> None:
        """Check that there is an episode and that it is not over.

        Raises:
            EpisodeError: there is none, or it is over; ``what`` names the call.
        """
        self.require(what)
        if self._over:
            raise EpisodeError(f"{what} after the end: this episode is over, call reset() first")

    def render(self, env: UcONEnv) -> NDArray[np.uint8] | list[NDArray[np.uint8]] | None:
        """The current frame, or with ``rgb_array_list`` all frames since the last call.

        Returns:
            (384, 768, 3) uint8 each; None without a render mode.

        Raises:
            EpisodeError: there is no episode.
        """
        if self._mode is None:
            return None
        self.require("render")
        base = cast(UcONEnv, env.unwrapped)
        if self._mode == "rgb_array":
            return base.draw(base.moment())
        moments, self._moments = self._moments, []
        return [base.draw(moment) for moment in moments]
