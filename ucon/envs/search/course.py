"""What environments of choices have in common: when a step may be taken, and the frames between two choices."""

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
    """How far the episode of an environment of choices has come, as whoever chooses was told."""

    _flat = frozenset({"_moments"})

    def __init__(self, render_mode: str | None) -> None:
        check_render_mode(render_mode, RENDER_MODES)
        self._mode = render_mode
        self._begun = self._over = False
        self._moments: list[Moment] = []

    def begin(self, env: UcONEnv) -> None:
        """An episode has begun in ``env``."""
        self._begun, self._over = True, False
        self._moments.clear()
        self.note(env)

    def note(self, env: UcONEnv) -> None:
        """A primitive step was taken; where all frames are shown, it will be drawn when they are asked for."""
        if self._mode == "rgb_array_list":
            self._moments.append(cast(UcONEnv, env.unwrapped).moment())

    def told(self, *, over: bool) -> None:
        """Whoever chooses was told whether the episode is over."""
        self._over = over

    def close(self) -> None:
        """The environment was closed."""
        self._begun = False
        self._moments.clear()

    def require(self, what: str) -> None:
        """Raise :class:`EpisodeError` where there is no episode."""
        if not self._begun:
            raise EpisodeError(f"{what} before reset, or after close: call reset() first")

    def require_open(self, what: str) -> None:
        """Raise :class:`EpisodeError` where there is no episode, or where it is over."""
        self.require(what)
        if self._over:
            raise EpisodeError(f"{what} after the end: this episode is over, call reset() first")

    def render(self, env: UcONEnv) -> NDArray[np.uint8] | list[NDArray[np.uint8]] | None:
        """The frame of now, or all since the last call."""
        if self._mode is None:
            return None
        self.require("render")
        base = cast(UcONEnv, env.unwrapped)
        if self._mode == "rgb_array":
            return base.draw(base.moment())
        moments, self._moments = self._moments, []
        return [base.draw(moment) for moment in moments]
