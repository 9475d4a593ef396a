"""Plays a policy in several environments at once, with one forward pass for all: for validation and for DAgger."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.progress import part
from ucon.core.rng import stream
from ucon.learning.policies.action_policy import Arrays, rounded_logits, stacked, tensors_of
from ucon.task.episode import Episode

if TYPE_CHECKING:
    from torch import Tensor, nn

    Env = Any


@dataclass(frozen=True)
class Job:
    """One episode to be played at one habit level."""

    episode: Episode
    level: str


@dataclass(frozen=True)
class RolloutOutcome:
    """Actions and result of a played job; an episode that was cut off counts as failed."""

    job: Job
    actions: str
    success: bool
    spl: float


class Seen(NamedTuple):
    """A frame as the environment gives it."""

    observation: Mapping[str, Any]
    info: Mapping[str, Any]


class Chooser(Protocol):
    """Turns the logits of a step into an action."""

    def begin(self, number: int, job: Job, env: Env, info: Mapping[str, Any]) -> None:
        """Called when job ``number`` starts in an environment, before its first :meth:`choose`."""
        ...

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        """The action to take.

        Args:
            number: index of the job.
            step: of the episode, from 0.
            logits: (7,) float64.
            seen: the frame.

        Returns:
            Index of the action.
        """
        ...


class PolicyChooser:
    """Takes the action with the highest logit, or samples from the policy's probabilities.

    Args:
        sample: True to sample.
        seed, keys: of the random stream; the number of the job and the step are added, so draws do not depend on which
            environment plays a job.
    """

    def __init__(self, sample: bool, seed: int, *keys: str | int) -> None:
        self._sample, self._seed, self._keys = sample, seed, keys

    def begin(self, number: int, job: Job, env: Env, info: Mapping[str, Any]) -> None:
        """Nothing to prepare."""

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        """Action index from logits (7,); see :class:`Chooser`."""
        if not self._sample:
            return int(logits.argmax())
        weights = np.exp(logits - logits.max())
        return int(stream(self._seed, *self._keys, number, step).choice(len(weights), p=weights / weights.sum()))


@dataclass
class _Slot:
    """One environment with the episode that it plays now."""

    env: Env
    number: int = -1
    observation: Any = None
    info: Any = None
    context: Mapping[str, Tensor] = field(default_factory=dict)
    state: Mapping[str, Tensor] = field(default_factory=dict)
    """Recurrent state; tensors (...), without a batch axis."""
    actions: list[int] = field(default_factory=list)


class Players:
    """Plays jobs with one policy in a fixed number of environments.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module.
        make_env: makes an environment of ``UcON-v0``; called as often as environments are needed.
        slots: environments played at once. Results can depend on it in their last bits, so it is part of the seed.
        max_steps: episodes are cut off after this many actions.
    """

    def __init__(self, policy: nn.Module, make_env: Callable[[], Env], slots: int, max_steps: int) -> None:
        self._policy: Any = policy
        self._make_env, self._n_slots, self._max_steps = make_env, slots, max_steps
        self._envs: list[Env] = []

    def play(self, jobs: Sequence[Job], chooser: Chooser, what: str = "playing") -> list[RolloutOutcome]:
        """Play all jobs; the policy is in evaluation mode meanwhile.

        Args:
            jobs: what to play.
            chooser: turns logits into actions.
            what: label of the progress line.

        Returns:
            One outcome per job, in the order of ``jobs``.
        """
        import torch

        was_training, results = self._policy.training, dict[int, RolloutOutcome]()
        self._policy.eval()
        while len(self._envs) < min(self._n_slots, len(jobs)):
            self._envs.append(self._make_env())
        waiting = iter(enumerate(jobs))
        running = [slot for env in self._envs if self._begin(slot := _Slot(env), waiting, chooser)]
        with torch.inference_mode(), part(what, len(jobs)) as tick:
            while running:
                still = []
                for slot, logits in zip(running, self._forward(running), strict=True):
                    seen = Seen(slot.observation, slot.info)
                    done = self._step(slot, chooser.choose(slot.number, len(slot.actions), logits, seen))
                    if done:
                        results[slot.number] = self._result(slot, jobs[slot.number])
                        tick(len(results))
                    if not done or self._begin(slot, waiting, chooser):
                        still.append(slot)
                running = still
        self._policy.train(was_training)
        return [results[number] for number in range(len(jobs))]

    def close(self) -> None:
        """Close the environments; a later call makes new ones."""
        while self._envs:
            self._envs.pop().close()

    def _begin(self, slot: _Slot, waiting: Iterator[tuple[int, Job]], chooser: Chooser) -> bool:
        """Reset a slot to the next job with a fresh recurrent state; False where no job is left."""
        number, job = next(waiting, (-1, None))
        if job is None:
            return False
        options = {"episode": job.episode, "habit_level": job.level}
        slot.observation, slot.info = slot.env.reset(seed=0, options=options)
        slot.number, slot.actions = number, []
        slot.context = self._tensors(self._policy.context(slot.info))
        slot.state = {name: tensor[0] for name, tensor in self._policy.initial_state(1).items()}
        chooser.begin(number, job, slot.env, slot.info)
        return True

    def _forward(self, slots: Sequence[_Slot]) -> NDArray[np.float64]:
        """Logits (B, 7) of the next step of B slots; updates each slot's recurrent state."""
        frames = [self._tensors(self._policy.frame(slot.observation, slot.info)) for slot in slots]
        steps = {name: tensor[None] for name, tensor in stacked(frames).items()}  # (1, B, ...)
        context, state = stacked([slot.context for slot in slots]), stacked([slot.state for slot in slots])
        outputs = self._policy(steps, context, state)
        for row, slot in enumerate(slots):
            slot.state = {name: tensor[row] for name, tensor in outputs.state.items()}
        return rounded_logits(outputs.logits[0])

    def _step(self, slot: _Slot, action: int) -> bool:
        """Take an action in a slot; True where its episode is over or cut off."""
        slot.actions.append(action)
        slot.observation, _, terminated, truncated, slot.info = slot.env.step(action)
        return bool(terminated or truncated) or len(slot.actions) >= self._max_steps

    @staticmethod
    def _result(slot: _Slot, job: Job) -> RolloutOutcome:
        metrics = slot.info.get("episode_metrics", {})
        actions = "".join(map(str, slot.actions))
        return RolloutOutcome(job, actions, bool(metrics.get("success", False)), float(metrics.get("spl", 0.0)))

    def _tensors(self, arrays: Arrays) -> dict[str, Tensor]:
        return tensors_of(arrays, next(self._policy.parameters()).device)
