"""``UcON-v0``: the seven-action environment (paper, section III)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal, SupportsFloat

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.core.sharing import PartlyShared
from ucon.envs.frame import StartFrame
from ucon.envs.knowledge import HabitSource
from ucon.envs.options import (
    check_choice,
    check_render_mode,
    checked_action,
    make_detector,
    make_renderer,
    returned_info,
    with_texts,
)
from ucon.envs.own_home import is_home_file, own_set
from ucon.envs.painter import Moment, Painter
from ucon.envs.robot import checked_planner, new_ledger, read_depth, rigged_rules
from ucon.envs.spaces import observation_space, padded
from ucon.envs.tour import Tour, hide
from ucon.perception.detectors import Detector, Frame
from ucon.perception.mapping.nav import Nav
from ucon.sim.cache import load_house
from ucon.sim.state import SceneState
from ucon.task.actions import NO_ACTION, Action, encoded_action
from ucon.task.begin import begun_search
from ucon.task.check import check_home
from ucon.task.episode import Episode
from ucon.task.ledger import Ledger
from ucon.task.reward import Reward
from ucon.task.robot.rig import RobotRig
from ucon.task.robot.search import RobotSearch
from ucon.task.search import StepOutcome
from ucon.task.sets import load_episodes

#: Side of the canonical view, in which pixels are counted at the rules' angle of view.
CANONICAL_PX = 128

Obs = dict[str, Any]
Images = tuple[NDArray[np.uint8], NDArray[np.float32]]
"""Colours (H, W, 3) uint8 and depth (H, W) float32."""


class UcONEnv(PartlyShared, gym.Env[Obs, int]):
    """Find the target where this household keeps it.

    ### Description
    A robot stands in a home it does not know. It is given a target category and the habits of the people who live
    there; some of them say where the target may be. It has 300 steps.

    ### Action space
    ``Discrete(7)``: MoveAhead 0.25 m, RotateRight 90, RotateLeft 90, LookUp 30, LookDown 30, Open, Done.
    With ``task="real_robot"`` rotations are by 60 degrees, and moves and turns have the errors of its ``rig``.

    ### Observation space
    | key | space | meaning |
    |---|---|---|
    | rgb | uint8 (H, W, 3) | camera image (``observe="pixels"``) |
    | depth | float32 (H, W) | metres along the optical axis; 0: no reading (``observe="pixels"``) |
    | pose | float32 (4,) | x, y in metres, yaw, pitch in radians, relative to the start; a robot's own estimate |
    | target | float32 (D,) | embedding of the target's name |
    | habits | int32 (max_habits,) | rows of ``env.unwrapped.habit_table``, -1 = padding |
    | habits_mask | int8 (max_habits,) | 1 for rows that are habits |
    | last_action | int8 (7,) | one-hot code of the last action, zeros at the start |
    | collision | int8 (1,) | 1: the last move was blocked |
    | step | int64 (1,) | steps taken, 0 to max_steps |

    ### Info
    ``target`` (category), ``camera_m`` (the camera's height), ``fov_deg`` (its angle of view); at reset ``task`` (name
    of the rules), ``context`` (a sentence or None; ``told``: the same as :class:`ucon.habits.contexts.Context`),
    ``habits`` (texts), ``habit_rows``, ``habit_level``, ``episode`` (id, for seeds and logs), at level ``context``
    ``reranking`` (:class:`ucon.retrieval.ContextHabits`: re-ranks the habits by what was seen), with
    ``planner="true"`` ``nav`` (free grid in the agent's frame); with a detector (True: ``gt``) ``detections``,
    ``tracks`` and ``opened`` (tracks); at the end ``episode_metrics`` and ``is_success``. With ``privileged=True`` also
    ``privileged`` (scene, episode, solution, locations, target instance and position, pose, tour): for trainers and
    oracles only. With ``texts=False`` info has numbers and arrays only. This is the default in worker processes of
    Gymnasium's ``AsyncVectorEnv``, since TorchRL accepts nothing else.

    ### Rewards
    :class:`ucon.task.reward.Reward`: +10 for a successful Done and -0.01 a step by default.

    ### Termination
    Done terminates; 300 steps truncate. After the end of an episode ``step`` raises until the next reset.

    ### Copies
    ``copy.deepcopy`` and ``pickle`` give an independent environment in the same state. Copies share homes, habits,
    embeddings and episodes; of those that every installation has, a pickle stores only the names.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 6}  # noqa: RUF012 (Gymnasium's own name and type)
    _shared: ClassVar[frozenset[str]] = frozenset(
        {"episodes", "episode", "source", "rules", "_reward", "_frame", "_locations", "_habit_rows", "_habits"}
        | {"_habits_mask", "_target_embedding", "spec", "metadata"}
    )
    _left_out: ClassVar[frozenset[str]] = frozenset({"_painter", "_images", "_view"})

    def __init__(
        self,
        episodes: str | Path | Sequence[Episode] = "mini",
        *,
        habit_level: str = "retrieval",
        source: HabitSource | None = None,
        task: str = "paper",
        least_pixels: int | None = None,
        observe: Literal["pixels", "symbolic"] = "pixels",
        width_px: int = CANONICAL_PX,
        height_px: int = CANONICAL_PX,
        fov_deg: float | None = None,
        detector: bool | Detector | None = False,
        planner: Literal["true", "observed"] | None = None,
        renderer: Literal["raster", "tiny"] = "raster",
        world: Literal["compiled", "live"] = "compiled",
        rig: RobotRig | None = None,
        reward: Reward | None = None,
        max_habits: int = 1024,
        privileged: bool = False,
        texts: bool | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment; homes are loaded at the first reset.

        Args:
            episodes: name of a set (``mini``, ``val``, ``test``), a file, a home file (YAML), or episodes.
            habit_level: which habits the agent is given: none, full, gt, retrieval, context.
            source: gives every episode its habits; by default the habit book, or the habits of the home file.
            task: name of the rule set.
            least_pixels: least pixels for Done and Open, for sensitivity analyses; None: as in the rule set.
            observe: ``pixels`` for images in observations, ``symbolic`` for none.
            width_px: width of the images.
            height_px: height of the images.
            fov_deg: horizontal angle of view; None: the rules', 90 in the paper's.
            detector: False for none, True for ``gt``, or a detector.
            planner: ``true`` puts the true free grid into info, ``observed`` does not; None: ``true`` if there is a
                grid.
            renderer: ``raster``, or ``tiny`` (PyBullet's).
            world: ``compiled`` arrays, or ``live`` PyBullet.
            rig: rig of the robot with ``task="real_robot"``; None: its default.
            reward: weights of a step's reward.
            max_habits: rows of habits in observations.
            privileged: put privileged facts into info.
            texts: whether info holds texts; None: yes except in worker processes.
            render_mode: None or ``rgb_array``.

        Raises:
            ConfigError: an option has an unknown value.
            EpisodeError: there are no such episodes.
        """
        check_choice("observe", observe, ("pixels", "symbolic"))
        check_choice("planner", planner, ("true", "observed", None))
        check_choice("world", world, ("compiled", "live"))
        check_render_mode(render_mode, ("rgb_array",))
        if is_home_file(episodes):
            own = own_set(Path(str(episodes)), task)
            episodes, source = own.episodes, source or HabitSource(own.dataset)
        self.episodes = load_episodes(episodes, task) if isinstance(episodes, str | Path) else tuple(episodes)
        if not self.episodes:
            raise EpisodeError("no episodes: expected at least one; name a set (mini, val, test) or give a path")
        self.rules, self._rig = rigged_rules(task, rig, least_pixels)
        planner, fov_deg = checked_planner(planner, self.rules), self.rules.fov_deg if fov_deg is None else fov_deg
        self.source = source or HabitSource()
        self.habit_level = self.source.check_level(habit_level)
        self.render_mode = render_mode
        self._observe, self._planner, self._detector = observe, planner, make_detector(detector)
        self._world_kind, self._reward, self._privileged = world, reward or Reward(), privileged
        self._max_habits, self._texts = max_habits, with_texts(texts)
        self._renderer = make_renderer(renderer, width_px, height_px, fov_deg, self.rules.fov_deg)
        self._canonical = (width_px, height_px, fov_deg) == (CANONICAL_PX, CANONICAL_PX, self.rules.fov_deg)
        self._fov_deg = fov_deg
        self._painter: Painter | None = None
        self._world: Any = None
        self._ledger: Ledger | None = None
        self._over = False
        self.action_space = spaces.Discrete(len(Action))  # type: ignore[assignment]  # it draws NumPy integers
        image = (height_px, width_px) if observe == "pixels" else None
        self.observation_space = observation_space(image, self.source.dimension, max_habits, self.rules.max_steps)
        self._instance, self._habit_rows = np.empty((height_px, width_px), np.int16), np.empty(0, np.int32)
        self._images: Images | None = None
        self._view: tuple[NDArray[np.float32] | None, NDArray[np.uint8] | None] = (None, None)

    @property
    def detector(self) -> Detector | None:
        """The detector whose output is in ``info``; None without one."""
        return self._detector

    @property
    def rig(self) -> RobotRig | None:
        """How the robot is built and errs; None under rules with a grid."""
        return self._rig

    @property
    def pose(self) -> NDArray[np.float32]:
        """The pose in observations, (4,) float32: the true pose on the grid, or the estimate of a robot's odometry."""
        if isinstance(self.search, RobotSearch):
            return self.search.odometry
        return self._frame.pose(self.search.pose)

    @property
    def max_habits(self) -> int:
        """Rows of habits in observations, which is the length of the longest list of habits that can be given."""
        return self._max_habits

    @property
    def ledger(self) -> Ledger:
        """The running metrics of the current episode. Privileged.

        Raises:
            EpisodeError: there is none.
        """
        return self._begun("ledger")

    @property
    def tour(self) -> Tour:
        """A walk through the home of the current episode, before its first step. Privileged."""
        return self._tour

    @property
    def habit_table(self) -> NDArray[np.float16]:
        """Embeddings of all N habits of the dataset, (N, D) float16, read-only; ``obs["habits"]`` are its rows."""
        return self.source.table

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Obs, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: draws the episode, unless one is given.
            options: ``episode``, an Episode, an id or an index; ``habit_level``, the level for this episode only;
                ``hide_target``, True: detectors that read instances never show the target (for trainers); ``frame``,
                a Start: poses and the grid are relative to it instead of the episode's start; ``same_home``, True: the
                detector keeps the tracks of the episode before, whose home must have the same instances.

        Returns:
            Observation and info; see the class.

        Raises:
            EpisodeError: no such episode, or it does not fit its home or the habits in use.
            ConfigError: an unknown habit level, or more habits than ``max_habits``.
        """
        super().reset(seed=seed)
        self._ledger = None  # after a failed reset nothing can be continued
        self.episode = self._choose(options or {})
        self._hides_target = bool((options or {}).get("hide_target", False))
        level = self.source.check_level((options or {}).get("habit_level", self.habit_level))
        tracked = self._world is not None and bool((options or {}).get("same_home", False))
        house = load_house(self.episode.scene)
        check_home(self.episode, house)
        self._enter(house)
        self.search = begun_search(self.episode, self._world, self._renderer, self.rules, self._rig)
        self._frame = StartFrame((options or {}).get("frame", self.episode.start))
        self._knowledge = self.source.knowledge(self.episode, level)
        self._give_habits()
        self._target_embedding = self._knowledge.target_embedding.astype(np.float32)
        if self._detector is not None and not tracked:
            self._detector.reset(self.episode.id, self._world.categories)
        self._last_action, self._collision = NO_ACTION, 0
        self._over = False
        self._painter = None
        self._locations = self.source.locations(self.episode, house) if self._privileged else ()
        self._tour = Tour(self.search, self._renderer, self._detector, self._frame, self._fov_deg)
        self._view = self._draw()
        self._ledger = new_ledger(self.episode, self.search)
        obs, info = self._observed(opened=())
        told = self.source.told(self.episode)
        info |= {
            "episode": self.episode.id,
            "task": self.rules.name,
            "context": told and told.sentence(),
            "habit_level": level,
            "habits": self._knowledge.texts,
            "habit_rows": tuple(self._knowledge.rows.tolist()),
        }
        if told is not None:
            info["told"] = told
        if self._knowledge.reranking is not None:
            info["reranking"] = self._knowledge.reranking
        if self._detector is not None and hasattr(self._detector, "errors"):  # others never err
            info["detector"] = self._detector.name
            if (errors := self._detector.errors) is not None:
                info["detector_errors"] = errors
        if self._planner == "true":
            info["nav"] = Nav(*self._frame.grid(self._world.free))
        return obs, returned_info(info, texts=self._texts)

    def step(self, action: int) -> tuple[Obs, SupportsFloat, bool, bool, dict[str, Any]]:
        """Carry out one action.

        Args:
            action: 0 to 6, see :class:`ucon.task.actions.Action`.

        Returns:
            Observation, reward, terminated, truncated, info; see the class.

        Raises:
            EpisodeError: before the first reset, or after the end of an episode.
            ActionError: not an action; nothing was done.
        """
        outcome, reward, truncated = self.advance(action)
        obs, info = self._observed(outcome.opened)
        if self._over:
            info["episode_metrics"], info["is_success"] = self.ledger.outcome().to_json(), self.ledger.success
        return obs, reward, outcome.done, truncated, returned_info(info, texts=self._texts)

    def advance(self, action: int) -> tuple[StepOutcome, float, bool]:
        """Carry out one action and draw the images, as :meth:`step` does, but make no observation.

        Meant for batches of environments, where most entries of the observations stay as they are.

        Args:
            action: 0 to 6.

        Returns:
            What the action did, the reward, and whether the episode is truncated.

        Raises:
            EpisodeError: see :meth:`step`.
            ActionError: see :meth:`step`.
        """
        ledger, potential = self._begun("step"), self._reward.progress != 0
        if self._over:
            raise EpisodeError(f"episode {self.episode.id} is over after {ledger.steps} steps: call reset() first")
        action = checked_action(action, len(Action))
        before_m = ledger.to_goal_m() if potential else 0.0
        self._give_habits()
        outcome = self.search.step(action)
        self._last_action, self._collision = action, int(outcome.collision)
        truncated = not outcome.done and ledger.steps + 1 >= self.rules.max_steps
        self._view = self._draw()
        ledger.note(action, outcome)
        self._over = outcome.done or truncated
        closer_m = before_m - ledger.to_goal_m() if potential else 0.0
        reward = self._reward(
            success=outcome.success, done=outcome.done, collision=outcome.collision, closer_m=closer_m
        )
        return outcome, reward, truncated

    def draw_images_into(self, images: Images | None) -> None:
        """Set the arrays that the renderer writes the next images into; observations then hold these arrays.

        Args:
            images: C-contiguous colours and depth; None: new arrays for each observation, the default.
        """
        self._images = images

    def action_masks(self) -> NDArray[np.bool_]:
        """Actions that may be chosen, for MaskablePPO: all seven, since a mask must not reveal what an action would do.

        Returns:
            (7,) bool.
        """
        self._begun("action_masks")
        return np.ones(len(Action), bool)

    def moment(self) -> Moment:
        """The current state, which :meth:`draw` can draw now or later in the episode."""
        ledger = self._begun("moment")
        return Moment.of(self.search, ledger)

    def draw(self, moment: Moment) -> NDArray[np.uint8]:
        """Draw a moment of this episode.

        Returns:
            The camera's image and the top-down map beside it, (384, 768, 3) uint8.
        """
        if self._painter is None:
            self._painter = Painter(self.search, self._begun("draw"))
        return self._painter.draw(moment)

    def render(self) -> NDArray[np.uint8] | None:
        """The current frame: the camera's image and the top-down map beside it.

        Returns:
            (384, 768, 3) uint8; None without a ``render_mode``.
        """
        return None if self.render_mode is None else self.draw(self.moment())

    def close(self) -> None:
        """Release the renderer and, with ``world="live"``, the PyBullet client; a reset makes them again."""
        self._renderer.close()
        if self._detector is not None:
            self._detector.close()
        if self._world is not None and self._world_kind == "live":
            self._world.close()
        self._world = self._ledger = self._painter = None

    def _begun(self, what: str) -> Ledger:
        """The metrics of the current episode; raises if there is none (``what`` names the call)."""
        if self._ledger is None:
            raise EpisodeError(f"{what} before reset, or after close: call reset() first")
        return self._ledger

    def _enter(self, house: Any) -> None:
        """Build the episode's world and load it into the renderer."""
        arrangement = self.episode.arrangement
        if self._world_kind == "live":
            from ucon.sim.live import LiveState

            if self._world is not None:
                self._world.close()
            self._world = LiveState(house, arrangement)
        else:
            self._world = SceneState(house, arrangement)
        self._renderer.load(house, arrangement)

    def _observed(self, opened: tuple[int, ...]) -> tuple[Obs, dict[str, Any]]:
        """Observation and info of the last drawn frame, which has image, depth, instances and pixel counts."""
        pose, camera_m = self.pose, self.search.camera[2]
        info: dict[str, Any] = {"target": self.episode.target_category, "camera_m": camera_m, "fov_deg": self._fov_deg}
        obs: Obs = {"pose": pose}
        (depth, rgb), self._view = self._view, (None, None)
        if self._observe == "pixels":
            obs["rgb"], obs["depth"] = rgb, depth
        elif depth is not None:
            info["depth"] = depth
        if self._detector is not None and depth is not None:
            counts, counts_fov_deg = self.search.counts, self.rules.fov_deg
            frame = Frame(depth, rgb, pose, camera_m, self._fov_deg, self._instance, counts, counts_fov_deg)
            info["detections"] = found = self._detector.detect(frame)
            info["tracks"] = found.image
            info["opened"] = self._detector.tracks_of(opened)
        if self._privileged:
            info["privileged"] = {
                "solution": self.episode.solution,
                "target_instance": self.search.target,
                "pose": self.search.pose,
                "scene": self.episode.scene,
                "episode": self.episode,
                "locations": self._locations,
                "tour": self._tour,
                "target_xyz": self._target_xyz(),
            }
        obs["target"] = self._target_embedding.copy()
        obs["habits"], obs["habits_mask"] = self._habits.copy(), self._habits_mask.copy()
        obs["last_action"] = encoded_action(self._last_action)
        obs["collision"], obs["step"] = np.array([self._collision], np.int8), np.array([self.ledger.steps])
        return obs, info

    def _target_xyz(self) -> NDArray[np.float64]:
        """Centre of the target, (3,) metres in the frame of poses."""
        box = self._world.boxes[self.search.target]
        return self._frame.point(0.5 * (box[:3] + box[3:]), self._world.house.grid)

    def _draw(self) -> tuple[NDArray[np.float32] | None, NDArray[np.uint8] | None]:
        """Draw depth (H, W) and colours (H, W, 3), each if needed; instances and pixel counts are kept."""
        pixels, detector, shape = self._observe == "pixels", self._detector, self._instance.shape
        rgb, depth = self._images or (None, None)
        if depth is None and (pixels or detector is not None):
            depth = np.empty(shape, np.float32)
        if rgb is None and (pixels or (detector is not None and detector.needs_rgb)):
            rgb = np.empty((*shape, 3), np.uint8)
        if depth is None:
            return None, None
        instance = self._instance if detector is not None else None
        counts = np.empty(len(self._world.boxes), np.int32) if self._canonical else None
        self._renderer.render(*self.search.camera, rgb=rgb, depth=depth, instance=instance, counts=counts)
        if self._hides_target:
            hide(self.search.target, instance, counts)
        if counts is not None:
            self.search.saw(counts)
        if isinstance(self.search, RobotSearch):
            read_depth(self.search, depth, self._fov_deg)
        return depth, rgb

    def _give_habits(self) -> None:
        """Update ``habits`` and ``habits_mask`` of observations; at level ``context`` from the current ranking."""
        rows = (self._knowledge.reranking or self._knowledge).rows
        if rows is not self._habit_rows:
            self._habits, self._habits_mask = padded(rows, self._max_habits, f"episode {self.episode.id}")
            self._habit_rows = rows

    def _choose(self, options: dict[str, Any]) -> Episode:
        """The episode of ``options``, else one drawn from the seed."""
        wanted = options.get("episode")
        if wanted is None:
            return self.episodes[int(self.np_random.integers(len(self.episodes)))]
        if isinstance(wanted, Episode):
            return wanted
        if isinstance(wanted, str):
            for episode in self.episodes:
                if episode.id == wanted:
                    return episode
            raise EpisodeError(f"no episode '{wanted}' among the {len(self.episodes)} of this environment")
        if not 0 <= int(wanted) < len(self.episodes):
            raise EpisodeError(f"episode index {wanted}, expected 0 to {len(self.episodes) - 1}")
        return self.episodes[int(wanted)]
