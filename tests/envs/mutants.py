"""Wrappers that each break the contract of an environment in one way; ``check-env`` must catch them all."""

from __future__ import annotations

from contextlib import suppress
from copy import copy
from typing import Any

import gymnasium as gym
import numpy as np

from ucon.core.errors import EpisodeError
from ucon.envs.checking.subject import core


class Mutant(gym.Wrapper[Any, Any, Any, Any]):
    """Base class: subclasses change what goes into or comes out of the environment."""

    def reset(self, **given: Any) -> Any:
        self.taken = 0
        self.last: Any = None
        obs, info = self.env.reset(**self.asked(given))
        return self.tell(dict(obs), dict(info))

    def step(self, action: Any) -> Any:
        obs, reward, terminated, truncated, info = self.env.step(self.act(action))
        self.taken += 1
        obs, info = self.tell(dict(obs), dict(info))
        return obs, *self.judge(reward, terminated, truncated, info), info

    def asked(self, given: dict[str, Any]) -> dict[str, Any]:
        return given

    def act(self, action: Any) -> Any:
        return action

    def tell(self, obs: Any, info: Any) -> Any:
        return obs, info

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return reward, terminated, truncated


class WorldFrame(Mutant):
    """Poses are in the world frame."""

    def tell(self, obs: Any, info: Any) -> Any:
        x, y = core(self).search.xy
        obs["pose"] = np.array([x, y, *obs["pose"][2:]], np.float32)
        return obs, info


class MirroredFrame(Mutant):
    """Left is right."""

    def tell(self, obs: Any, info: Any) -> Any:
        obs["pose"] = obs["pose"] * np.array([1, -1, -1, 1], np.float32)
        return obs, info


class Degrees(Mutant):
    """Pitch is in degrees."""

    def tell(self, obs: Any, info: Any) -> Any:
        obs["pose"] = np.array([*obs["pose"][:3], np.degrees(obs["pose"][3])], np.float32)
        return obs, info


class LeakedPosition(Mutant):
    """The target's place is in info."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs, info | {"hint": core(self).episode.target_object.position}


class LeakedScene(Mutant):
    """The scene's name is in info."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs, info | {"where": core(self).episode.scene}


class LeakedSolution(Mutant):
    """The stored solution is in info."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs, info | {"plan": core(self).episode.solution}


class LeakedDistance(Mutant):
    """The distance to the target is in info, under a harmless name."""

    def tell(self, obs: Any, info: Any) -> Any:
        place = np.asarray(core(self).episode.target_object.position)
        return obs, info | {"battery": float(np.linalg.norm(place[:2] - core(self).search.xy) + 0.1 * place[2])}


class Undead(Mutant):
    """Steps after the end of an episode are accepted."""

    def step(self, action: Any) -> Any:
        with suppress(EpisodeError):
            self.last = super().step(action)
        return self.last


class SeedsIgnored(Mutant):
    """Every reset draws at random, whatever the seed."""

    def asked(self, given: dict[str, Any]) -> dict[str, Any]:
        return given | {"seed": None}


class SeedsForgotten(Mutant):
    """Every seed gives the first episode."""

    def asked(self, given: dict[str, Any]) -> dict[str, Any]:
        return given if given.get("options") else given | {"options": {"episode": 0}}


class EpisodeIgnored(Mutant):
    """The requested episode is not played."""

    def asked(self, given: dict[str, Any]) -> dict[str, Any]:
        return given | {"options": None, "seed": 1}


class RewardedFailure(Mutant):
    """Done is rewarded wherever it is said."""

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return (10.0 if terminated else reward), terminated, truncated


class UnpaidSuccess(Mutant):
    """Success is not rewarded."""

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return min(reward, -0.01), terminated, truncated


class InvertedMask(Mutant):
    """Valid choices are masked out."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"action_mask": (1 - obs["action_mask"]).astype(np.int8)}, info


class WideMask(Mutant):
    """Rows without a choice are offered."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"action_mask": np.ones_like(obs["action_mask"])}, info


class MaskedMoves(Mutant):
    """Moves that would be blocked are masked, which reveals what the agent has not seen."""

    def action_masks(self) -> Any:
        return np.array([False] + [True] * 6)


class OtherLevel(Mutant):
    """Habits are those of another level."""

    def asked(self, given: dict[str, Any]) -> dict[str, Any]:
        return given | {"options": (given.get("options") or {}) | {"habit_level": "full"}}


class HabitMaskLate(Mutant):
    """The mask of the habits covers one too few."""

    def tell(self, obs: Any, info: Any) -> Any:
        mask = obs["habits_mask"].copy()
        mask[max(0, int(mask.sum()) - 1) :] = 0
        return obs | {"habits_mask": mask}, info


class OtherTarget(Mutant):
    """Info names another target."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs, info | {"target": "mug"}


class Stale(Mutant):
    """Images are those of the step before."""

    def tell(self, obs: Any, info: Any) -> Any:
        before, self.last = self.last or obs, obs
        return obs | {"rgb": before["rgb"], "depth": before["depth"]}, info


class Millimetres(Mutant):
    """Depth is in millimetres."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"depth": obs["depth"] * 1000}, info


class SharedCopies(Mutant):
    """Copies are not independent: they move the original's agent."""

    def __deepcopy__(self, memo: Any) -> Any:
        return copy(self)


class StiffCopies(Mutant):
    """Copies start from the beginning."""

    def __deepcopy__(self, memo: Any) -> Any:
        new = type(self)(gym.make("UcON-v0", disable_env_checker=True))
        new.reset(options={"episode": 0})
        return new


class CutEarly(Mutant):
    """Episodes are truncated a step too early."""

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return reward, terminated, truncated or self.taken == 299


class CutNever(Mutant):
    """The last step does not end the episode."""

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return reward, terminated, False


class DoneGoesOn(Mutant):
    """Done does not end the episode."""

    def judge(self, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return reward, False, truncated


class AlwaysSuccess(Mutant):
    """Every end is a success."""

    def tell(self, obs: Any, info: Any) -> Any:
        if "episode_metrics" in info:
            info["episode_metrics"] = info["episode_metrics"] | {"success": True}
        return obs, info


class TurnsCount(Mutant):
    """The path length counts turns too."""

    def tell(self, obs: Any, info: Any) -> Any:
        if "episode_metrics" in info:
            info["episode_metrics"] = info["episode_metrics"] | {
                "path_length_m": 0.25 * info["episode_metrics"]["steps"]
            }
        return obs, info


class NeverCollides(Mutant):
    """Collisions are never reported."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"collision": np.zeros(1, np.int8)}, info


class LateAction(Mutant):
    """``last_action`` is one step late."""

    def tell(self, obs: Any, info: Any) -> Any:
        before, self.last = (np.zeros(7, np.int8) if self.last is None else self.last), obs["last_action"]
        return obs | {"last_action": before}, info


class StepsFromOne(Mutant):
    """Steps are counted from 1."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"step": obs["step"] + 1}, info


class AnyAction(Mutant):
    """Invalid actions are accepted."""

    def act(self, action: Any) -> Any:
        return action if isinstance(action, int | np.integer) and 0 <= action < self.action_space.n else 1  # type: ignore[attr-defined]


class WrongType(Mutant):
    """Poses are not float32 arrays."""

    def tell(self, obs: Any, info: Any) -> Any:
        return obs | {"pose": obs["pose"].tolist()}, info


class StillPicture(Mutant):
    """``render`` always shows the start."""

    def render(self) -> Any:
        if self.last is None:
            self.last = self.env.render()
        return self.last


OF_CHOICES = (InvertedMask, WideMask)
OF_ACTIONS = tuple(cls for cls in Mutant.__subclasses__() if cls not in OF_CHOICES)
