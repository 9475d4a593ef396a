"""``UcONWaypoint-v0``: choose where to look next; walking, opening and taking are done for you."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, SupportsFloat

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.sharing import PartlyShared
from ucon.envs.options import checked_action, told, with_texts
from ucon.envs.ucon_env import Obs, UcONEnv
from ucon.envs.waypoint.choosing import RENDER_MODES, Course
from ucon.envs.waypoint.explorer import Explorer, Info, Manner
from ucon.envs.waypoint.features import N_FEATURES, N_THINGS, category_rows, features, things
from ucon.envs.waypoint.strategies import STRATEGIES, Strategy
from ucon.perception.candidates import Candidate
from ucon.retrieval.base import phrase
from ucon.task.actions import Action

#: Nothing lies farther away, costs more actions or is larger than this, in any unit.
_MOST = 1e4
#: What only the map needs of a frame.
_FRAME = ("detections", "tracks", "opened", "depth")
_CARRIED = ("pose", "target", "habits", "habits_mask", "step")


class UcONWaypointEnv(PartlyShared, gym.Env[Obs, int]):
    """Search a home by choosing among candidates.

    ### Description
    Wraps ``UcON-v0``: a step chooses one candidate; the planner walks there, looks around, opens what is closed and in
    reach, and as soon as the target is in view walks up to it and says Done. Every primitive action costs one of the
    300 steps.

    ### Action space
    ``Discrete(max_candidates)``: the row of a candidate. Rows whose ``action_mask`` is 0 are no candidates; choosing
    one turns the agent left, which costs a step, and sets ``info["invalid"]``.

    ### Observation space
    | key | space | meaning |
    |---|---|---|
    | candidates | float32 (C, 12) | kind (one-hot: frontier, landmark, container, view, wander), metres ahead and to \
the left, actions to get there, cells of a frontier, share of a thing not looked at, free metres, number of things |
    | candidate_things | int32 (C, 8) | rows of ``env.unwrapped.category_table`` of what is seen there, -1 = padding |
    | action_mask | int8 (C,) | 1 where a candidate stands |
    | pose, target, habits, habits_mask, step | | as in ``UcON-v0`` |

    ### Info
    That of ``UcON-v0`` at the last primitive step without detections; ``candidates`` (of
    :mod:`ucon.perception.candidates`), ``primitive_steps`` taken by this step, ``invalid``.

    ### Rewards
    The sum of those of the primitive steps; the first step's holds the look around at the start as well.

    ### Termination
    That of ``UcON-v0``. Where the target comes into view while looking around at the start, one candidate is offered,
    and any choice takes it.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 6}  # noqa: RUF012 (Gymnasium's own name and type)
    _shared: ClassVar[frozenset[str]] = frozenset({"spec", "metadata", "_strategy", "_manner", "_last"})

    options_of = UcONEnv
    """Whose options it takes beside its own."""

    def __init__(
        self,
        episodes: Any = "mini",
        *,
        strategy: str | Callable[[Info], Strategy] = "landmarks",
        manner: Manner | None = None,
        max_candidates: int = 256,
        seed: int = 0,
        observe: str = "symbolic",
        detector: Any = True,
        texts: bool | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        """Describe the environment.

        Args:
            episodes: see ``UcON-v0``.
            strategy: a name, or what makes a strategy from the info at reset.
            manner: how choices are carried out.
            max_candidates: rows of the observation; ``landmarks`` offered up to 144 in the mini set, the others 16.
            seed: of what the strategy draws.
            observe: see ``UcON-v0``.
            detector: what candidates come from; see ``UcON-v0``.
            texts: see ``UcON-v0``.
            render_mode: ``rgb_array``, or ``rgb_array_list``: all frames since the last call, between choices too.
            **options: of ``UcON-v0``.

        Raises:
            ConfigError: an unknown strategy, or no detector.
        """
        if isinstance(strategy, str) and strategy not in STRATEGIES:
            raise ConfigError(unknown_name("strategy", strategy, STRATEGIES))
        if not detector:
            raise ConfigError("detector=None: candidates come from what is detected; name a detector")
        self.env = UcONEnv(episodes, observe=observe, detector=detector, texts=True, **options)  # type: ignore[arg-type]
        self._course = Course(render_mode)
        self.render_mode, self._texts = render_mode, with_texts(texts)
        self._strategy = STRATEGIES[strategy] if isinstance(strategy, str) else strategy
        self._manner, self._most, self._seed = manner or Manner(), max_candidates, seed
        self._explorer: Explorer | None = None
        self.action_space = spaces.Discrete(max_candidates)  # type: ignore[assignment]  # it draws NumPy integers
        inner: Any = self.env.observation_space
        carried = {name: inner[name] for name in _CARRIED}
        self.observation_space = spaces.Dict(
            {
                "candidates": spaces.Box(-_MOST, _MOST, (max_candidates, N_FEATURES), np.float32),
                "candidate_things": spaces.Box(-1, len(category_rows()) - 1, (max_candidates, N_THINGS), np.int32),
                "action_mask": spaces.MultiBinary(max_candidates),
                **carried,
            }
        )

    @property
    def habit_table(self) -> NDArray[np.float16]:
        """See ``UcON-v0``."""
        return self.env.habit_table

    @property
    def category_table(self) -> NDArray[np.float16]:
        """(n, D) float16 embeddings of the catalogue's names: what ``candidate_things`` numbers."""
        return self.env.source.encoder.encode_half([phrase(name) for name in category_rows()])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start an episode, as ``UcON-v0`` does, and look around."""
        super().reset(seed=seed)
        self._course.close()  # a reset that fails leaves nothing to go on with
        obs, start = self.env.reset(seed=seed, options=options)
        self._explorer = explorer = Explorer(start, self._strategy(start), self._manner, self._seed)
        self._course.begin(self.env)
        self._last, self._over, self._reward, self._primitives = (obs, dict(start)), (False, False), 0.0, 0
        self._pending = explorer.look(obs, start)
        while self._pending is not None and not explorer.taking and not any(self._over):
            self._play(self._pending)
        obs, info = self._observed()
        start = {name: value for name, value in start.items() if name not in _FRAME}
        return obs, told(start | info | {"invalid": False}, texts=self._texts)

    def step(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Choose a candidate, and play until the next choice is due or the episode ends.

        Raises:
            EpisodeError: before the first reset, or after the end of an episode.
            ActionError: no row of the observation; nothing was done.
        """
        self._course.require_open("step")
        assert self._explorer is not None
        action = checked_action(action, self._most)
        invalid = action >= max(1, len(self._offered()))
        if self._pending is None and not any(self._over):
            self._pending = Action.ROTATE_LEFT if invalid else self._explorer.choose(action)
        while self._pending is not None:
            self._play(self._pending)
        obs, info = self._observed()
        reward, self._reward, self._primitives = self._reward, 0.0, 0
        terminated, truncated = self._over
        self._course.told(over=terminated or truncated)
        return obs, reward, terminated, truncated, told(info | {"invalid": invalid}, texts=self._texts)

    def _play(self, action: Action) -> None:
        """One primitive step; what follows it is pending."""
        assert self._explorer is not None
        obs, reward, terminated, truncated, info = self.env.step(int(action))
        self._last, self._over = (obs, info), (terminated, truncated)
        self._course.note(self.env)
        self._reward += float(reward)
        self._primitives += 1
        self._pending = None if terminated or truncated else self._explorer.look(obs, info)

    def _offered(self) -> tuple[Candidate, ...]:
        """The candidates of the choice that is due."""
        if self._explorer is None or self._pending is not None or any(self._over):
            return ()
        found = self._explorer.decision().candidates
        if len(found) <= self._most:
            return found
        raise ConfigError(f"{len(found)} candidates, expected at most {self._most}; raise max_candidates")

    def _observed(self) -> tuple[Obs, dict[str, Any]]:
        assert self._explorer is not None
        (obs, info), found = self._last, self._offered()
        mask = self.action_masks().astype(np.int8)
        out = {
            "candidates": features(found, self._explorer.map.view, self._most),
            "candidate_things": things(found, self._most),
            "action_mask": mask,
            **{name: obs[name] for name in _CARRIED},
        }
        kept = {name: value for name, value in info.items() if name not in _FRAME}
        return out, kept | {"candidates": found, "primitive_steps": self._primitives}

    def action_masks(self) -> NDArray[np.bool_]:
        """(C,) rows that may be chosen, as MaskablePPO asks: ``action_mask`` of the last observation.

        Raises:
            EpisodeError: before the first reset.
        """
        self._course.require("action_masks")
        return np.arange(self._most) < max(1, len(self._offered()))

    def render(self) -> NDArray[np.uint8] | list[Any] | None:
        """A frame as in ``UcON-v0``, or with ``rgb_array_list`` those of all primitive steps since the last call."""
        return self._course.render(self.env)

    def close(self) -> None:
        """See ``UcON-v0``."""
        self._course.close()
        self.env.close()
