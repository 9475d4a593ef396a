"""``UcONSearch-v0``: choose the next view to go to from tokens. The habit policy is trained on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, SupportsFloat, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.fingerprint import fingerprint_of
from ucon.core.sharing import PartlyShared
from ucon.envs.knowledge import HabitSource
from ucon.envs.options import checked_action, returned_info, with_texts
from ucon.envs.search.course import RENDER_MODES, Course
from ucon.envs.ucon_env import Obs, UcONEnv
from ucon.objects.catalogue import catalogue
from ucon.perception.belief.from_habits import Locate, ReadHabits, expecting
from ucon.search.map_raster import CHANNELS, SIDE
from ucon.search.search_tokens import N_EGO, N_FRONTIER, N_THING, Sizes, TokenReader, Tokens
from ucon.search.searcher import MISS, Searcher
from ucon.search.text_tokens import EpisodeTextTokens, TextTokens
from ucon.search.view_tokens import N_VIEW
from ucon.task.actions import Action

#: Keys of info that only the map needs; left out of the info returned.
_FRAME = ("detections", "tracks", "opened", "depth")
#: Bound of the observation space's float entries.
_MOST = 1e4


@dataclass(frozen=True)
class Returns:
    """Weights of an episode's return, paid at its end."""

    spl: float = 1.0
    """Weight of SPL."""
    success: float = 0.0
    """For a success."""
    speed: float = 0.5
    """For a success at step 0; falls linearly to 0 at the last step."""
    contained: float = 0.0
    """Added for a success with a target that was behind closed doors."""

    def __call__(self, metrics: dict[str, Any], max_steps: int) -> float:
        """The return of an episode; 0 without success.

        Args:
            metrics: the episode's ``episode_metrics``.
            max_steps: step limit of the rules.
        """
        if not metrics["success"]:
            return 0.0
        worth = self.spl * float(metrics["spl"]) + self.success + self.speed * (1.0 - int(metrics["steps"]) / max_steps)
        return worth + (self.contained if metrics["contained"] else 0.0)


class UcONSearchEnv(PartlyShared, gym.Env[Obs, int]):
    """Search a home by choosing among views.

    ### Description
    Wraps ``UcON-v0``. A step chooses a view. The planner goes towards it and asks again after five actions. On the way
    it opens closed containers that are worth a step. As soon as the target is in view, the planner walks up to it and
    calls Done. The habits are read once, or at level ``context`` whenever their list changes; the belief in places that
    were looked at in vain is lowered. If there is at most one view to choose, the environment does not ask. Every
    primitive action costs one of the 300 steps.

    ### Action space
    ``Discrete(V)``: the row of a view. Rows whose ``action_mask`` is 0 are not views; choosing one turns the agent
    left, which costs a step, and sets ``info["invalid"]``.

    ### Observation space
    ``views``, ``prior``, ``things``, ``thing_rows``, ``things_mask``, ``frontiers``,
    ``frontiers_mask``, ``ego``, ``map``: see :class:`ucon.search.search_tokens.Tokens`; ``target``, ``habits``,
    ``habits_relevance``, ``habits_mask``: see :meth:`ucon.search.text_tokens.TextTokens.read`; ``action_mask`` int8
    (V,), 1 for rows that are views.

    ### Rewards
    0 before the end of an episode, then the return of :class:`Returns`.

    ### Termination
    That of ``UcON-v0``.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 6}  # noqa: RUF012 (Gymnasium's own name and type)
    _shared: ClassVar[frozenset[str]] = frozenset(
        {"spec", "metadata", "_locate", "_sizes", "_text", "_returns", "_last", "_tokens", "_locations"}
    )

    options_of = UcONEnv
    """The environment whose options this one accepts besides its own."""

    def __init__(
        self,
        episodes: Any = "mini",
        *,
        locate: Locate | None = None,
        miss: float = MISS,
        sizes: Sizes | None = None,
        text: TextTokens | None = None,
        returns: Returns | None = None,
        observe: str = "symbolic",
        detector: Any = True,
        texts: bool | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        """Make the environment; homes and weights are loaded at the first reset.

        Args:
            episodes: see ``UcON-v0``.
            locate: maps an info to the distribution over the target's place; by default read from the habits.
            miss: probability that a frame that shows a place misses a target there.
            sizes: numbers of token rows.
            text: embeds names and habits.
            returns: weights of an episode's return.
            observe: see ``UcON-v0``.
            detector: the detector whose output is mapped; see ``UcON-v0``.
            texts: see ``UcON-v0``.
            render_mode: ``rgb_array``, or ``rgb_array_list``: all frames since the last call, also between choices.
            **options: options of ``UcON-v0``.

        Raises:
            ConfigError: there is no detector.
        """
        if not detector:
            raise ConfigError("detector=None: views are valued by what is detected; name a detector")
        self.env = UcONEnv(episodes, observe=observe, detector=detector, texts=True, **options)  # type: ignore[arg-type]
        self._course = Course(render_mode)
        self.render_mode, self._texts = render_mode, with_texts(texts)
        self._locate, self._miss, self._sizes = locate or ReadHabits(), miss, sizes or Sizes()
        self._text, self._returns = text or TextTokens(), returns or Returns()
        self._searcher: Searcher | None = None
        self.action_space = spaces.Discrete(self._sizes.views)  # type: ignore[assignment]  # it draws NumPy integers
        self.observation_space = observation_space(self._sizes, self._text)

    @property
    def source(self) -> HabitSource:
        """The habits of the episodes."""
        return self.env.source

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start an episode, see ``UcON-v0``, and play until there are two views to choose from.

        Returns:
            Observation and info.
        """
        super().reset(seed=seed)
        self._course.close()  # after a failed reset nothing can be continued
        obs, info = self.env.reset(seed=seed, options=options)
        self._locations = self._locate(info)
        believing = expecting(info, self._locate, locations=self._locations)
        self._searcher = Searcher(info, believing, miss=self._miss)
        self._reader = TokenReader(self._searcher, info, self._sizes)
        self._said = EpisodeTextTokens(self._text, str(info["target"]), believing)
        self._last, self._over = (obs, info), (False, False)
        self._tokens: Tokens | None = None
        self._course.begin(self.env)
        self._until_due(None)
        return self._observed(), returned_info(
            {**_kept(info), **_kept(self._last[1]), "invalid": False}, texts=self._texts
        )

    def step(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Choose a view, and play until there are two views to choose from again or the episode ends.

        Args:
            action: row of the view.

        Returns:
            Observation, reward, terminated, truncated, info (with ``invalid``).

        Raises:
            EpisodeError: before the first reset, or after the end of an episode.
            ActionError: not a row of the observation; nothing was done.
        """
        self._course.require_open("step")
        assert self._searcher is not None
        action = checked_action(action, self._sizes.views)
        offered = self._tokens.choices if self._tokens is not None else ()
        invalid = action >= max(1, len(offered))
        if not any(self._over):
            choice = None if invalid or not offered else offered[action]
            self._until_due(self._searcher.choose(choice))
        info = self._last[1]
        self._course.note_over(over=any(self._over))
        return (
            self._observed(),
            self._reward(info),
            *self._over,
            returned_info(_kept(info) | {"invalid": invalid}, texts=self._texts),
        )

    def _until_due(self, action: Action | None) -> None:
        """Play ``action`` and what follows until a choice among two views or more is due, or the episode ends."""
        assert self._searcher is not None
        self._tokens = None
        while True:
            if action is not None:
                obs, _, *over, info = self.env.step(int(action))
                self._last, self._over = (obs, info), (over[0], over[1])
                self._course.note(self.env)
                if any(over):
                    return
            action = self._look()
            if action is None:
                self._tokens = self._reader.read(self._searcher.decision())
                if len(self._tokens.choices) > 1:
                    return
                action = self._searcher.choose(next(iter(self._tokens.choices), None))

    def _look(self) -> Action | None:
        """Take in the newest frame; returns the next action, or None if a choice is due."""
        assert self._searcher is not None
        return self._searcher.look(*self._last)

    def _reward(self, info: dict[str, Any]) -> float:
        """Reward of a choice: the return of the episode at its end, else 0."""
        if not any(self._over):
            return 0.0
        return self._returns(info["episode_metrics"], cast(UcONEnv, self.env.unwrapped).rules.max_steps)

    def _observed(self) -> Obs:
        """The observation of the choice that is due; zeros at the end of the episode."""
        if self._tokens is None:  # the episode is over
            blank = {name: np.zeros(space.shape, space.dtype) for name, space in self.observation_space.items()}  # type: ignore[attr-defined]
            blank["action_mask"][0] = 1
            return blank | self._text_arrays()
        return {**self._tokens.arrays, **self._text_arrays()}

    def _text_arrays(self) -> Obs:
        """The text arrays of the observation. Copies: the caller may change them."""
        return {name: array.copy() for name, array in self._said().items()}

    def action_masks(self) -> NDArray[np.bool_]:
        """Rows that may be chosen, for MaskablePPO: ``action_mask`` of the last observation.

        Returns:
            (V,) bool.

        Raises:
            EpisodeError: before the first reset.
        """
        self._course.require("action_masks")
        offered = 0 if self._tokens is None else len(self._tokens.choices)
        return np.arange(self._sizes.views) < max(1, offered)

    def render(self) -> NDArray[np.uint8] | list[Any] | None:
        """The current frame, or with ``rgb_array_list`` the frames of all primitive steps since the last call.

        Returns:
            (384, 768, 3) uint8 each; None without a render mode.
        """
        return self._course.render(self.env)

    def close(self) -> None:
        """Release what the environment holds; a reset makes it again."""
        self._course.close()
        self.env.close()

    def fingerprint(self) -> str:
        """Checksum of the trained reader's weights; "" without trained weights.

        It is stored in the run's record (:mod:`ucon.evaluation.playing.needed_weights`).
        """
        return str(fingerprint_of(self._locate))


def observation_space(sizes: Sizes, text: TextTokens) -> spaces.Dict:
    """The observation space of :class:`UcONSearchEnv`.

    Args:
        sizes: numbers of token rows.
        text: gives the length of embeddings and the number of habits.
    """

    def box(*shape: int) -> spaces.Box:
        return spaces.Box(-_MOST, _MOST, shape, np.float32)

    d, habits = text.encoder.dim, text.n_habits
    return spaces.Dict(
        {
            "views": box(sizes.views, N_VIEW),
            "prior": box(sizes.views),
            "action_mask": spaces.MultiBinary(sizes.views),
            "things": box(sizes.things, N_THING),
            "thing_rows": spaces.Box(-1, len(catalogue().names) - 1, (sizes.things,), np.int32),
            "things_mask": spaces.MultiBinary(sizes.things),
            "frontiers": box(sizes.frontiers, N_FRONTIER),
            "frontiers_mask": spaces.MultiBinary(sizes.frontiers),
            "ego": box(N_EGO),
            "map": spaces.Box(0, 255, (len(CHANNELS), SIDE, SIDE), np.uint8),
            "target": box(d),
            "habits": box(habits, d),
            "habits_relevance": box(habits),
            "habits_mask": spaces.MultiBinary(habits),
        }
    )


def _kept(info: dict[str, Any]) -> dict[str, Any]:
    """The info without the keys that only the map needs."""
    return {name: value for name, value in info.items() if name not in _FRAME}
