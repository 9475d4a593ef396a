"""Plays whole episodes with the policy alone, many at once, and records the log-probabilities of its actions.

A collection is cut into parts of a fixed size. Each is a function of weights, seed and its numbers alone, so it is the
same whichever process plays it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.learning.episodes.experience import COMPARE, Experience, discounted, generalised_advantages
from ucon.learning.imitation.replaying import Replayer
from ucon.learning.imitation.rollouts import Rollouts
from ucon.learning.imitation.trajectories import Replay
from ucon.learning.policies.playing import Job, Players, PolicyChooser, Seen

if TYPE_CHECKING:
    from torch import Tensor, nn

    from ucon.learning.policies.action_policy import ActionPolicy


@dataclass(frozen=True)
class EpisodeRollouts(Rollouts):
    """How many episodes one collection plays, and how they are learned from.

    Raises:
        ConfigError: a number out of range.
    """

    episodes: int = 64
    """Episodes of one collection."""
    max_steps: int = 300
    """Episodes are cut off after this many actions."""
    epochs: int = 1
    """Passes over a collection."""
    temperature: float = 1.0
    """Actions are drawn at this temperature, which is part of the policy that is learned."""
    discount: float = 0.99
    """Discount of rewards per step."""
    trace: float = 0.95
    """Lambda of the generalised advantages."""
    repeats: int = 1
    """Times that each episode is played. With more than one, episodes are compared with their repetitions
    (:func:`ucon.learning.episodes.experience.compared`) and ``trace`` concerns the value's targets alone."""
    compare: str = "spl"
    """Figure by which repetitions are compared: ``spl``, or ``return``, the discounted rewards."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require_counts("epochs", "repeats")
        if self.episodes % self.repeats:
            raise ConfigError(f"learner.rollouts.episodes={self.episodes}: not a multiple of repeats={self.repeats}")
        if self.compare not in COMPARE:
            raise ConfigError(f"learner.rollouts.compare={brief(self.compare)}: must be {' or '.join(COMPARE)}")
        self.require_shares("discount", "trace")
        if type(self.temperature) not in (int, float) or not 0 < self.temperature <= 100:
            raise ConfigError(f"learner.rollouts.temperature={brief(self.temperature)}: must be above 0, at most 100")


@dataclass(frozen=True)
class EpisodePart:
    """Some episodes of a collection, played at once."""

    iteration: int
    """Number of the collection."""
    first: int
    """Number of the first episode in the collection."""
    jobs: tuple[Job, ...]
    weights: Mapping[str, Tensor]
    """State of the policy that plays, by name."""
    seed: int


class EpisodeCollector:
    """Plays parts of collections, in this process.

    Args:
        policy: plays, with the weights of each part.
        make_env: makes an environment of ``UcON-v0``; called when the first part comes.
        rollouts: how it is played.
        device: that the policy plays on; it is moved there when the first part comes.

    Attributes:
        replayer: plays trajectories again.
    """

    def __init__(
        self, policy: nn.Module, make_env: Callable[[], Any], rollouts: EpisodeRollouts, device: str = "cpu"
    ) -> None:
        self._policy, self._rollouts, self._device = policy, rollouts, device
        self.replayer = Replayer(cast("ActionPolicy", policy), make_env)
        self._players = Players(policy, make_env, rollouts.slots, rollouts.max_steps, keep_frames=True)

    def __call__(self, part: EpisodePart) -> list[tuple[Experience, Replay]]:
        """Play one part.

        Returns:
            For each job, what was done and what the policy saw, in the order of the jobs.
        """
        self._policy.to(self._device).load_state_dict(part.weights)
        given, chooser = self._rollouts, _Remembering(part, self._rollouts.temperature)
        played = []
        for number, one in enumerate(self._players.play(part.jobs, chooser, "collecting")):
            assert one.replay is not None  # keep_frames
            values = np.array(one.values, np.float32)
            advantage = generalised_advantages(one.replay.rewards, values, given.discount, given.trace)
            log_p = np.array(chooser.log_p[number], np.float32)
            did, gained = one.actions, discounted(one.replay.rewards, given.discount)
            experience = Experience(
                one.job.episode, one.job.level, did, did, log_p, advantage, advantage + values, one.success, one.spl,
                gained, led=one.job.led,
            )  # fmt: skip
            played.append((experience, one.replay))
        return played

    def close(self) -> None:
        """Close the environments; a later call makes new ones."""
        self._players.close()
        self.replayer.close()


class _Remembering(PolicyChooser):
    """Draws the policy's actions and remembers their log-probabilities, by number of the job."""

    def __init__(self, part: EpisodePart, temperature: float) -> None:
        super().__init__(True, part.seed, "episodes", part.iteration, part.first, temperature=temperature)
        self._at = temperature
        self.log_p: dict[int, list[float]] = {}

    def begin(self, number: int, job: Job, env: Any, info: Mapping[str, Any]) -> None:
        self.log_p[number] = []

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        action = super().choose(number, step, logits, seen)
        scaled = (logits - logits.max()) / self._at
        self.log_p[number].append(float(scaled[action] - np.log(np.exp(scaled).sum())))
        return action
