"""``UcONImageGoal-v0``: go to the pose at which a given image was taken. ZSON is trained on it.

Images and names share CLIP's embedding space, so a policy that has learned to reach images can be given names, although
it was never trained on names (Majumdar et al., NeurIPS 2022, section 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, SupportsFloat, cast

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, EpisodeError
from ucon.core.rng import stream
from ucon.core.sharing import PartlyShared
from ucon.envs.knowledge import HabitSource
from ucon.envs.options import with_texts
from ucon.envs.ucon_env import Obs, UcONEnv
from ucon.sim.paths import UNREACHABLE, distances, metres
from ucon.sim.render import RasterRenderer
from ucon.task.actions import Action
from ucon.task.search import Pose, Search


@dataclass(frozen=True)
class ImageGoalReward:
    """The reward of ZSON: for reaching the goal, for the heading of the image, and for progress towards both."""

    success: float = 5.0
    """For Done near the goal."""
    facing: float = 5.0
    """Added if Done succeeds with the heading of the image."""
    progress: float = 1.0
    """For every metre nearer to the goal."""
    turned: float = 1.0
    """For every radian turned towards the image's heading, near the goal."""
    step: float = -0.01
    """For every step."""


class UcONImageGoalEnv(PartlyShared, gym.Env[Obs, int]):
    """Reach the pose that an image shows.

    ### Description
    Homes, starts, observations and actions are those of ``UcON-v0`` with images. ``info["goal_image"]`` is the camera's
    image at the goal, given at reset and with ``texts=False`` also at every step. The goal is a reachable node at least
    ``least_m`` away and a heading, both drawn from the episode's id. The episode's target and habits have no meaning
    here.

    ### Action space, observation space
    Those of ``UcON-v0``.

    ### Rewards
    See :class:`ImageGoalReward`.

    ### Termination
    Done ends the episode, with success if the path to the goal is at most ``near_m`` long; 300 steps truncate it.
    ``info["episode_metrics"]`` has ``success``, ``spl`` and ``steps``; ``info["is_success"]`` is the first of them.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 6}  # noqa: RUF012 (Gymnasium's own name and type)
    _shared: ClassVar[frozenset[str]] = frozenset({"spec", "metadata", "_reward", "_goal", "_field", "_shown"})

    options_of = UcONEnv
    """The environment whose options this one accepts besides its own."""

    def __init__(
        self,
        episodes: Any = "mini",
        *,
        reward: ImageGoalReward | None = None,
        near_m: float = 1.0,
        least_m: float = 2.0,
        observe: str = "pixels",
        texts: bool | None = None,
        **options: Any,
    ) -> None:
        """Make the environment; homes are loaded at the first reset.

        Args:
            episodes: see ``UcON-v0``.
            reward: weights of the reward.
            near_m: longest path to the goal at which Done succeeds, metres.
            least_m: least path length to the goal, metres; ignored where the home is too small.
            texts: see ``UcON-v0``.
            observe: ``pixels``, since goals are images.
            **options: options of ``UcON-v0``.

        Raises:
            ConfigError: observations without images, distances below 0, or rules without a grid.
        """
        if observe != "pixels":
            raise ConfigError(f"env.observe={observe}: goals are images; give env.observe=pixels")
        if not 0 <= near_m < 1e3 or not 0 <= least_m < 1e3:
            raise ConfigError(f"env.near_m={near_m}, env.least_m={least_m}: expected metres from 0 up")
        self.env = UcONEnv(episodes, observe="pixels", texts=texts, **options)
        self.env.rules.require_grid("image goals need nodes and headings of the grid")
        self.render_mode, self._texts = self.env.render_mode, with_texts(texts)
        self.action_space, self.observation_space = self.env.action_space, self.env.observation_space
        self._reward, self._near, self._least_m = reward or ImageGoalReward(), near_m, least_m
        self._goal: Pose | None = None

    @property
    def source(self) -> HabitSource:
        """The habits of the episodes; they have no meaning here."""
        return self.env.source

    @property
    def goal(self) -> Pose:
        """The pose at which the goal image was taken.

        Raises:
            EpisodeError: before the first reset.
        """
        if self._goal is None:
            raise EpisodeError("no goal before reset, or after close: call reset() first")
        return self._goal

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start an episode, see ``UcON-v0``.

        Returns:
            Observation and info, with ``goal_image`` (H, W, 3) uint8.
        """
        super().reset(seed=seed)
        self._goal = None
        obs, info = self.env.reset(seed=seed, options=options)
        self._goal = self._drawn()
        self._field = distances(self.env.search.world.free, [(self._goal.i, self._goal.j)])
        self._steps, self._moves, self._whole_m = 0, 0, self._to_go_m()
        self._shown = self._image(self._goal)
        return obs, info | {"goal_image": self._shown}

    def step(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Carry out one action.

        Returns:
            Observation, reward (:class:`ImageGoalReward`), terminated, truncated, info.

        Raises:
            EpisodeError: before the first reset, or after the end of an episode.
            ActionError: not an action; nothing was done.
        """
        goal, near = self.goal, self._to_go_m() <= self._near
        before_m, before_rad = self._to_go_m(), self._to_turn_rad()
        obs, _, done, truncated, info = self.env.step(action)
        self._steps += 1
        self._moves += int(action == Action.MOVE_AHEAD and not obs["collision"][0])
        success = done and near
        if not self._texts:
            info["goal_image"] = self._shown
        weights = self._reward
        reward = weights.step + weights.progress * (before_m - self._to_go_m())
        if near and self._to_go_m() <= self._near:
            reward += weights.turned * (before_rad - self._to_turn_rad())
        if success:
            reward += weights.success + weights.facing * (self.env.search.pose.heading == goal.heading)
        if done or truncated:
            walked = metres(self._moves)
            spl = self._whole_m / max(walked, self._whole_m) if success and self._whole_m > 0 else float(success)
            info["episode_metrics"] = {"success": success, "spl": spl, "steps": self._steps}
            info["is_success"] = success
        return obs, reward, done, truncated, info

    def _drawn(self) -> Pose:
        """A random goal: a reachable node at least ``least_m`` away (any, if there is none), and a heading."""
        start = self.env.search.pose
        away = distances(self.env.search.world.free, [(start.i, start.j)])
        far = np.argwhere(away >= self._least_m / metres(1))
        nodes = far if len(far) else np.argwhere(away != UNREACHABLE)
        draw = stream(0, "image goal", self.env.episode.id)
        i, j = nodes[int(draw.integers(len(nodes)))].tolist()
        return Pose(i, j, int(draw.integers(4)), start.height, start.pitch_deg)

    def _image(self, pose: Pose) -> NDArray[np.uint8]:
        """The camera's image at a pose, (H, W, 3) uint8."""
        search, eyes = self.env.search, cast(RasterRenderer, self.env.search.eyes)
        rgb = np.empty((eyes.height, eyes.width, 3), np.uint8)
        eyes.render(*Search(search.world, eyes, search.target, pose, search.rules).camera, rgb=rgb)
        return rgb

    def _to_go_m(self) -> float:
        """Path length to the goal in metres."""
        here = self.env.search.pose
        return metres(int(self._field[here.i, here.j]))

    def _to_turn_rad(self) -> float:
        """Angle between the current heading and the image's, radians."""
        quarters = (self.env.search.pose.heading - self.goal.heading) % 4
        return 0.5 * float(np.pi) * min(quarters, 4 - quarters)

    def action_masks(self) -> NDArray[np.bool_]:
        """(7,) bool, all True; see ``UcON-v0``."""
        return self.env.action_masks()

    def render(self) -> NDArray[np.uint8] | None:
        """A frame for people; see ``UcON-v0``."""
        return self.env.render()

    def close(self) -> None:
        """Release what the environment holds; see ``UcON-v0``."""
        self._goal = None
        self.env.close()
