"""An environment for TorchRL: observations are the arrays that a policy makes of them; episodes are drawn by a seed.

After ``set_seed(s)`` all following episodes and habit levels are a function of s, whatever was played before. So the
experience of a training step depends only on the weights, the seed and the step, and environments have no state to
save.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, cast

import torch
from tensordict import TensorDict, TensorDictBase
from torch import nn
from torchrl.data import Binary, Categorical, Composite, Unbounded
from torchrl.envs import Compose, EnvBase, InitTracker, TensorDictPrimer, TransformedEnv

from ucon.core.rng import stream
from ucon.learning.policies.action_policy import ActionPolicy, tensors_of
from ucon.task.episode import Episode

#: Entries of ``outcome`` (3,) at the last step of an episode; zeros before.
OUTCOME: Final = ("success", "spl", "steps")
#: Key of the recurrent state in a tensordict.
STATE: Final = "state"


class PolicyEnv(EnvBase):
    """One environment as a TorchRL ``EnvBase``.

    Args:
        policy: turns observations into arrays; its weights are not used.
        env: of ``UcON-v0`` or ``UcONSearch-v0``.
        episodes: to draw from.
        levels: habit levels; episodes take them in turn from a random first one, so that every batch mixes them.
    """

    def __init__(self, policy: nn.Module, env: Any, episodes: Sequence[Episode], levels: Sequence[str]) -> None:
        super().__init__(device=torch.device("cpu"), batch_size=torch.Size([]))
        self._policy, self._env = cast(ActionPolicy, policy), env
        self._episodes, self._levels = tuple(episodes), tuple(levels)
        self._set_seed(0)
        self._begin()
        self.observation_spec = Composite(frames=_specs(self._frames), context=_specs(self._context))
        self.action_spec = Categorical(int(env.action_space.n), shape=torch.Size([]))
        one = torch.Size([1])
        outcome = Unbounded(torch.Size([len(OUTCOME)]), dtype=torch.float32)
        self.reward_spec = Composite(reward=Unbounded(one, dtype=torch.float32), outcome=outcome)
        self.done_spec = Composite(
            {name: Binary(1, one, dtype=torch.bool) for name in ("done", "terminated", "truncated")}
        )
        self._set_seed(0)

    def _begin(self) -> None:
        """Draw the next episode and reset the environment to it."""
        draw = stream(self._draw_seed, "episode", self._count)
        first = int(stream(self._draw_seed, "level").integers(len(self._levels)))
        level = self._levels[(first + self._count) % len(self._levels)]
        episode = self._episodes[int(draw.integers(len(self._episodes)))]
        self._count += 1
        observation, info = self._env.reset(seed=0, options={"episode": episode, "habit_level": level})
        self._context = tensors_of(self._policy.context(info))
        self._frames = tensors_of(self._policy.frame(observation, info))

    def _observation(self) -> dict[str, dict[str, torch.Tensor]]:
        """Present frames and context as TorchRL expects them."""
        return {"frames": dict(self._frames), "context": dict(self._context)}

    def _reset(self, tensordict: TensorDictBase | None = None, **kwargs: Any) -> TensorDictBase:
        self._begin()
        ends = {name: torch.zeros(1, dtype=torch.bool) for name in ("done", "terminated", "truncated")}
        return TensorDict({**self._observation(), **ends}, [], device=self.device)

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Take an action. Reaching the step limit counts as terminated, not truncated.

        The limit is part of the task, and the steps left are in the frames, so no value is estimated beyond it.
        """
        observation, reward, terminated, truncated, info = self._env.step(int(tensordict["action"]))
        self._frames = tensors_of(self._policy.frame(observation, info))
        metrics = info.get("episode_metrics", {})
        outcome = torch.tensor([float(metrics.get(name, 0.0)) for name in OUTCOME])
        over = torch.tensor([bool(terminated or truncated)])
        ends = {"done": over, "terminated": over.clone(), "truncated": torch.zeros_like(over)}
        told = {"reward": torch.tensor([float(reward)]), "outcome": outcome}
        return TensorDict({**self._observation(), **told, **ends}, [], device=self.device)

    def _set_seed(self, seed: int | None) -> None:
        self._draw_seed, self._count = int(seed or 0), 0


def rollout_env(
    policy: nn.Module, make_env: Callable[[], Any], episodes: Sequence[Episode], levels: Sequence[str]
) -> TransformedEnv:
    """An environment with the policy's recurrent state in its tensordict, fresh at each reset.

    ``is_init`` marks resets.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module.
        make_env: makes an environment of ``UcON-v0`` or ``UcONSearch-v0``.
        episodes: to draw from.
        levels: habit levels, mixed.
    """
    made = TransformedEnv(PolicyEnv(policy, make_env(), episodes, levels), Compose(InitTracker()))
    if (primer := state_primer(policy)) is not None:
        made.append_transform(primer)
    return made


def state_primer(policy: nn.Module) -> TensorDictPrimer | None:
    """Transform that adds the policy's initial recurrent state at each reset; None for a policy without memory."""
    first = {name: tensor[0].detach().cpu().clone() for name, tensor in policy.initial_state(1).items()}  # type: ignore[operator]
    if not first:
        return None
    specs = {name: Unbounded(tensor.shape, dtype=tensor.dtype) for name, tensor in first.items()}

    def fresh(reset: torch.Tensor | None = None) -> TensorDict:
        return TensorDict({STATE: {name: tensor.clone() for name, tensor in first.items()}}, [])

    return TensorDictPrimer(Composite({STATE: Composite(specs)}), default_value=fresh, single_default_value=True)


def _specs(tensors: Mapping[str, torch.Tensor]) -> Composite:
    return Composite({name: Unbounded(tensor.shape, dtype=tensor.dtype) for name, tensor in tensors.items()})
