"""Checks of a configuration of ``learner=ppo`` before training begins."""

from __future__ import annotations

from typing import Any, Final, cast

from torch import nn

from ucon.core.device import AUTO
from ucon.core.errors import ConfigError
from ucon.envs.image_goal import UcONImageGoalEnv
from ucon.learning.policies.action_policy import ActionPolicy
from ucon.learning.policies.validation import Validation
from ucon.learning.run.option_checks import check

#: Largest permitted size of one collection's recurrent states, in bytes.
_MOST_STATE_BYTES: Final = 4 << 30
#: The same for ``frames=auto``: smaller, since a collection is copied more than once.
_USUAL_STATE_BYTES: Final = 1 << 30
_USUAL_FRAMES: Final = 9000


def check_choices(policy: object, validation: Validation) -> None:
    """Refuse an agent without a trainable policy, and a validation figure that PPO does not measure.

    Args:
        policy: what the configuration gives.
        validation: chooses the best checkpoint.

    Raises:
        ConfigError: naming what to give.
    """
    if not isinstance(policy, nn.Module):
        raise ConfigError("agent has no policy that can be trained; choose one that has, like agent=habit_policy")
    if validation.choose not in ("success_rate", "spl"):
        raise ConfigError(f"learner.validation.choose={validation.choose}: expected success_rate or spl")


def check_taught(policy: nn.Module, env: Any, objective: float) -> None:
    """Refuse a policy that would learn nothing, or the wrong thing, in these environments.

    Args:
        policy: what is trained.
        env: an environment of policies over the seven actions.
        objective: weight of PPO's clipped objective.

    Raises:
        ConfigError: naming what to give.
    """
    name = type(policy).__name__
    if isinstance(env.unwrapped, UcONImageGoalEnv) and not getattr(policy, "reads_goal_images", False):
        raise ConfigError(f"learner=image_goal: {name} reads names, not images of goals; give agent=zson")
    if objective == 0:
        raise ConfigError(f"learner.loss.objective=0: {name} would not learn what to choose; give a number above 0")


def collection_size(policy: ActionPolicy, frames: int | str) -> int:
    """Number of environment steps in one collection; a recurrent state is stored for each of them.

    ``auto`` is 9,000, or as many thousands (at least one) as fit into 1 GiB of states.

    Args:
        policy: decides the size of a state.
        frames: the number asked for, or ``auto``.

    Raises:
        ConfigError: states of more than 4 GiB; the message says how many steps are possible.
    """
    size = sum(tensor.nbytes for tensor in policy.initial_state(1).values())
    if frames == AUTO:
        room = _USUAL_STATE_BYTES // size if size else _USUAL_FRAMES
        return min(_USUAL_FRAMES, max(1000, room // 1000 * 1000))
    check("above 0 and whole", lambda x: x > 0, (int,), frames=frames)
    given = cast(int, frames)
    if given * size > _MOST_STATE_BYTES:
        raise ConfigError(
            f"learner.frames={given}: the memory of {policy.architecture} at each of them takes "
            f"{given * size / (1 << 30):.1f} GB; give learner.frames={_MOST_STATE_BYTES // size} or less"
        )
    return given
