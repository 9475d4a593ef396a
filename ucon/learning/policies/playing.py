"""Plays a policy in several environments at once, one forward for all: to validate it, and to let it stray (DAgger)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.progress import part
from ucon.core.rng import stream
from ucon.learning.policies.action_policy import Arrays, comparable, stacked, tensors_of
from ucon.task.episode import Episode

if TYPE_CHECKING:
    from torch import Tensor, nn

    Env = Any


@dataclass(frozen=True)
class Job:
    """An episode to be played at a habit level."""

    episode: Episode
    level: str


@dataclass(frozen=True)
class RolloutOutcome:
    """What came of a job. An episode that was cut short has failed."""

    job: Job
    actions: str
    success: bool
    spl: float


class Chooser(Protocol):
    """Turns logits into actions."""

    def begin(self, number: int, job: Job, env: Env) -> None:
        """Job ``number`` begins in an environment."""
        ...

    def choose(self, number: int, step: int, logits: NDArray[np.float64]) -> int:
        """The action of job ``number`` at a step, from its logits (7,)."""
        ...


class PolicyChooser:
    """The action of the highest logit, or one drawn by the policy's probabilities as a function of seed and keys."""

    def __init__(self, sample: bool, seed: int, *keys: str | int) -> None:
        self._sample, self._seed, self._keys = sample, seed, keys

    def begin(self, number: int, job: Job, env: Env) -> None:
        """See :class:`Chooser`."""

    def choose(self, number: int, step: int, logits: NDArray[np.float64]) -> int:
        """See :class:`Chooser`."""
        if not self._sample:
            return int(logits.argmax())
        heat = np.exp(logits - logits.max())
        return int(stream(self._seed, *self._keys, number, step).choice(len(heat), p=heat / heat.sum()))


@dataclass
class _Slot:
    """One environment and the episode in it."""

    env: Env
    number: int = -1
    observation: Any = None
    info: Any = None
    context: Mapping[str, Tensor] = field(default_factory=dict)
    state: Mapping[str, Tensor] = field(default_factory=dict)
    """Tensors (...), without a batch axis."""
    actions: list[int] = field(default_factory=list)


class Players:
    """Plays jobs with one policy.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a module.
        make_env: makes an environment of ``UcON-v0``; called for as many as are needed.
        slots: environments that are played at once. Part of what makes a run repeatable: sums depend on it.
        max_steps: episodes are cut short here.
    """

    def __init__(self, policy: nn.Module, make_env: Callable[[], Env], slots: int, max_steps: int) -> None:
        self._policy: Any = policy
        self._make_env, self._n_slots, self._max_steps = make_env, slots, max_steps
        self._envs: list[Env] = []

    def play(self, jobs: Sequence[Job], chooser: Chooser, what: str = "playing") -> list[RolloutOutcome]:
        """Play all jobs; results in their order. Puts the policy into evaluation mode while it plays.

        ``what``: progress calls it so.
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
                    done = self._step(slot, chooser.choose(slot.number, len(slot.actions), logits))
                    if done:
                        results[slot.number] = self._result(slot, jobs[slot.number])
                        tick(len(results))
                    if not done or self._begin(slot, waiting, chooser):
                        still.append(slot)
                running = still
        self._policy.train(was_training)
        return [results[number] for number in range(len(jobs))]

    def close(self) -> None:
        """Close the environments."""
        while self._envs:
            self._envs.pop().close()

    def _begin(self, slot: _Slot, waiting: Iterator[tuple[int, Job]], chooser: Chooser) -> bool:
        """Start the next job in a slot, with a fresh recurrent state; False where none is left."""
        number, job = next(waiting, (-1, None))
        if job is None:
            return False
        options = {"episode": job.episode, "habit_level": job.level}
        slot.observation, slot.info = slot.env.reset(seed=0, options=options)
        slot.number, slot.actions = number, []
        slot.context = self._tensors(self._policy.context(slot.info))
        slot.state = {name: tensor[0] for name, tensor in self._policy.initial_state(1).items()}
        chooser.begin(number, job, slot.env)
        return True

    def _forward(self, slots: Sequence[_Slot]) -> NDArray[np.float64]:
        """Logits (B, 7) of the next step; moves each slot's recurrent state on."""
        frames = [self._tensors(self._policy.frame(slot.observation, slot.info)) for slot in slots]
        steps = {name: tensor[None] for name, tensor in stacked(frames).items()}  # (1, B, ...)
        context, state = stacked([slot.context for slot in slots]), stacked([slot.state for slot in slots])
        outputs = self._policy(steps, context, state)
        for row, slot in enumerate(slots):
            slot.state = {name: tensor[row] for name, tensor in outputs.state.items()}
        return comparable(outputs.logits[0])

    def _step(self, slot: _Slot, action: int) -> bool:
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
