"""Many homes as one TorchRL environment with one tensordict; the renderer writes directly into its images."""

from __future__ import annotations

from typing import Any, Final, cast

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from tensordict import TensorDict, TensorDictBase
from torchrl.data import Binary, Bounded, Categorical, Composite, TensorSpec, Unbounded
from torchrl.envs import EnvBase

from ucon.core.errors import ActionError, ConfigError, EpisodeError, brief
from ucon.core.rng import stream
from ucon.envs.ucon_env import UcONEnv
from ucon.task.actions import Action, encoded_action

#: Largest number of slots.
MOST_SLOTS: Final = 1024
#: Options of ``UcON-v0`` whose results are not tensors.
_NOT_IN_TENSORS: Final = ("detector", "planner", "privileged", "texts", "render_mode")
_IMAGES: Final = ("rgb", "depth")
_ENDS: Final = ("done", "terminated", "truncated")
#: ``last_action`` of each action, (7, 7) int8.
_CODES: Final = np.stack([encoded_action(action) for action in Action])


class BatchedUcONEnv(EnvBase):
    """N environments of ``UcON-v0`` as one with batch size N; each slot has its own home and episode.

    Observations are those of :class:`ucon.envs.ucon_env.UcONEnv` with a first axis N. ``rgb`` (N, H, W, 3) uint8 and
    ``depth`` (N, H, W) float32 are new tensors at each step, which the renderer writes into and nothing copies
    (:func:`ucon.core.memory.keep_freed_memory` avoids a system call for their memory each time). Besides ``reward``
    (N, 1) there are ``success`` and ``spl`` (N, 1) float32, zero before the end of an episode. After ``set_seed(s)``
    the k-th episode of slot i is a function of s, i and k.

    Example:
        ``Collector(BatchedUcONEnv(32), policy, frames_per_batch=1024, total_frames=100_000)``
    """

    def __init__(self, slots: int = 32, episodes: Any = "mini", *, seed: int = 0, **options: Any) -> None:
        """Make the environments; they share episodes, habits and the geometry of homes.

        Args:
            slots: N.
            episodes: see ``UcON-v0``.
            seed: draws episodes.
            options: options of ``UcON-v0``, except those whose results are not tensors (detector, planner, privileged,
                texts, render_mode).

        Raises:
            ConfigError: an option has an invalid value, or is one of these.
            EpisodeError: there are no such episodes.
        """
        if type(slots) is not int or not 1 <= slots <= MOST_SLOTS:
            raise ConfigError(f"slots={brief(slots)}: expected a whole number from 1 to {MOST_SLOTS}")
        if odd := sorted(set(options) & set(_NOT_IN_TENSORS)):
            raise ConfigError(f"{odd[0]}: its results are not tensors; make single environments with gymnasium.make")
        super().__init__(device=None, batch_size=torch.Size([slots]))
        first = UcONEnv(episodes, planner="observed", texts=True, **options)
        options["source"] = first.source
        more = (UcONEnv(first.episodes, planner="observed", texts=True, **options) for _ in range(slots - 1))
        self._slots, self._all = [first, *more], list(range(slots))
        space = cast(spaces.Dict, first.observation_space).spaces
        self._image_shape = space["rgb"].shape[:2] if "rgb" in space else None  # type: ignore[index]
        self._told: dict[str, NDArray[Any]] = {
            name: np.zeros((slots, *(one.shape or ())), one.dtype) for name, one in space.items() if name not in _IMAGES
        } | {name: np.zeros((slots, 1), np.float32) for name in ("success", "spl")}
        self._ends = {name: np.zeros((slots, 1), bool) for name in _ENDS}
        self._images: dict[str, torch.Tensor] = {}
        self._make_specs(space)
        self._set_seed(seed)

    def _make_specs(self, space: dict[str, Any]) -> None:
        n, one = self.batch_size, torch.Size([*self.batch_size, 1])
        observed = Composite({name: _spec(part) for name, part in space.items()}).expand(n)
        for name in ("success", "spl"):
            observed[name] = Bounded(0.0, 1.0, one, dtype=torch.float32)
        self.observation_spec = observed
        self.action_spec = Categorical(len(Action), shape=n)
        self.reward_spec = Unbounded(one, dtype=torch.float32)
        self.done_spec = Composite({name: Binary(1, one, dtype=torch.bool) for name in _ENDS}, shape=n)

    def _reset(self, tensordict: TensorDictBase | None = None, **kwargs: Any) -> TensorDictBase:
        """Begin the next episode in every slot, or in those that ``_reset`` marks; the others stay as they are."""
        chosen = self._chosen(tensordict, "_reset")
        self._new_images(chosen)
        for slot in chosen:
            self._begin(slot)
        return self._tensors()

    def _begin(self, slot: int) -> None:
        """Draw a slot's next episode and reset its environment to it."""
        env, draw = self._slots[slot], stream(self._draw_seed, "slot", slot, self._begun[slot])
        self._begun[slot] += 1
        observation, _ = env.reset(seed=0, options={"episode": int(draw.integers(len(env.episodes)))})
        for name, rows in self._told.items():
            rows[slot] = observation.get(name, 0)  # nothing has succeeded yet
        for ends in self._ends.values():
            ends[slot] = False

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Take an action in every slot, or in those that ``_step`` marks; the others stay as they are.

        Raises:
            ActionError: an action is invalid; nothing was done.
            EpisodeError: the episode of a slot is over; nothing was done.
        """
        actions, chosen = tensordict["action"].numpy(), self._chosen(tensordict, "_step")
        self._check(actions, chosen)
        self._new_images(chosen)
        told, reward = self._told, np.zeros((len(self._slots), 1), np.float32)
        done, terminated, truncated = (self._ends[name] for name in _ENDS)
        for slot, action in zip(chosen, actions[chosen].tolist(), strict=True):
            env = self._slots[slot]
            outcome, reward[slot], truncated[slot] = env.advance(action)
            told["pose"][slot], told["collision"][slot], terminated[slot] = env.pose, outcome.collision, outcome.done
            if outcome.done or truncated[slot]:
                metrics = env.ledger.outcome()
                told["success"][slot], told["spl"][slot] = metrics.success, metrics.spl
        told["last_action"][chosen] = _CODES[actions[chosen]]
        told["step"][chosen] += 1
        done[chosen] = terminated[chosen] | truncated[chosen]
        return self._tensors().set("reward", torch.from_numpy(reward))

    def _check(self, actions: NDArray[np.int64], chosen: list[int]) -> None:
        """Refuse what any slot would refuse, before any of them has moved."""
        if (wrong := (actions < 0) | (actions >= len(Action))).any():
            slot, last = int(wrong.argmax()), len(Action) - 1
            raise ActionError(f"action={actions[slot]} of slot {slot}: expected a whole number from 0 to {last}")
        if (over := self._ends["done"][chosen]).any():
            slot = chosen[int(over.argmax())]
            raise EpisodeError(f"the episode of slot {slot} is over: reset that slot alone with _reset")

    def _chosen(self, tensordict: TensorDictBase | None, key: str) -> list[int]:
        """Slots that an entry (N,) or (N, 1) bool marks, ascending; all slots without such an entry."""
        marks = None if tensordict is None else tensordict.get(key, None)
        return self._all if marks is None else np.flatnonzero(marks.numpy()).tolist()

    def _new_images(self, chosen: list[int]) -> None:
        """Make the chosen slots render into new tensors; the other slots' current images are copied into them."""
        if self._image_shape is None:
            return
        before, shape = self._images, (*self.batch_size, *self._image_shape)
        n = int(np.prod(shape))
        block = np.empty(7 * n, np.uint8)  # NumPy asks for huge pages where a block is large
        depths, rgbs = block[: 4 * n].view(np.float32).reshape(shape), block[4 * n :].reshape(*shape, 3)
        self._images = {"rgb": torch.from_numpy(rgbs), "depth": torch.from_numpy(depths)}
        for slot in chosen:
            self._slots[slot].draw_images_into((rgbs[slot], depths[slot]))
        if len(chosen) < len(self._slots):
            others = sorted(set(self._all) - set(chosen))
            for name, image in self._images.items():
                image[others] = before[name][others]

    def _tensors(self) -> TensorDict:
        rows = {name: torch.from_numpy(row.copy()) for name, row in (self._told | self._ends).items()}
        return TensorDict(self._images | rows, self.batch_size, device=self.device)

    def _set_seed(self, seed: int | None) -> None:
        self._draw_seed, self._begun = int(seed or 0), [0] * len(self._slots)

    def close(self, **kwargs: Any) -> None:
        """Release the environments."""
        for env in self._slots:
            env.close()
        super().close(**kwargs)


def _spec(space: spaces.Space[Any]) -> TensorSpec:
    """The TorchRL spec of an entry of ``UcON-v0``'s observation space."""
    dtype, shape = torch.from_numpy(np.empty(0, space.dtype)).dtype, torch.Size(space.shape or ())
    if isinstance(space, spaces.MultiBinary):
        return Binary(shape[-1], shape, dtype=dtype)
    assert isinstance(space, spaces.Box)
    if dtype == torch.uint8:
        return Unbounded(shape, dtype=dtype)
    return Bounded(torch.from_numpy(space.low), torch.from_numpy(space.high), shape, dtype=dtype)
