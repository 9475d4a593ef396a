"""Plays a policy in several environments at once, with one forward pass for all: to validate, and to collect."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.progress import part
from ucon.core.rng import stream
from ucon.learning.imitation.trajectories import Replay
from ucon.learning.policies.action_policy import Arrays, rounded_logits, tensors_of
from ucon.task.episode import Episode

if TYPE_CHECKING:
    from torch import Tensor, dtype, nn

    Env = Any


@dataclass(frozen=True)
class Job:
    """One episode to be played at one habit level."""

    episode: Episode
    level: str
    led: str = ""
    """Actions taken before the policy begins, one digit each."""


@dataclass(frozen=True)
class RolloutOutcome:
    """Actions and result of a played job; an episode that was cut off counts as failed."""

    job: Job
    actions: str
    """The policy's, without those of ``job.led``."""
    success: bool
    spl: float
    replay: Replay | None = None
    """Context, frames and rewards of the episode; None unless the players keep frames."""
    values: tuple[float, ...] = ()
    """Estimated return before each action; empty unless the players keep frames."""


class Seen(NamedTuple):
    """A frame as the environment gives it."""

    observation: Mapping[str, Any]
    info: Mapping[str, Any]


def led(env: Env, actions: str, seen: Seen) -> Seen:
    """Take given actions, one digit each; returns the last frame, which is ``seen`` where there are no actions."""
    for digit in actions:
        observation, _, _, _, info = env.step(int(digit))
        seen = Seen(observation, info)
    return seen


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
        temperature: logits are divided by it before an action is sampled.
        seed, keys: of the random stream; the number of the job and the step are added, so draws do not depend on which
            environment plays a job.
    """

    def __init__(self, sample: bool, seed: int, *keys: str | int, temperature: float = 1.0) -> None:
        self._sample, self._seed, self._keys, self._temperature = sample, seed, keys, temperature

    def begin(self, number: int, job: Job, env: Env, info: Mapping[str, Any]) -> None:
        """Nothing to prepare."""

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        """Action index from logits (7,); see :class:`Chooser`."""
        if not self._sample:
            return int(logits.argmax())
        weights = np.exp((logits - logits.max()) / self._temperature)
        return int(stream(self._seed, *self._keys, number, step).choice(len(weights), p=weights / weights.sum()))


@dataclass
class _Slot:
    """One environment with the episode that it plays now."""

    env: Env
    number: int = -1
    seen: Seen = field(default_factory=lambda: Seen({}, {}))
    actions: list[int] = field(default_factory=list)
    context: Arrays = field(default_factory=dict)
    frames: list[Arrays] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def replay(self) -> Replay:
        """Context, frames and rewards of the episode, as arrays."""
        names = self.frames[0]
        frames = {name: np.stack([np.asarray(frame[name]) for frame in self.frames]) for name in names}
        return Replay(dict(self.context), frames, np.array(self.rewards, np.float32))


class _Batched:
    """Tensors (B, ...) by name, one row for each slot that plays: contexts, or recurrent states."""

    def __init__(self) -> None:
        self.tensors: dict[str, Tensor] = {}

    def append(self, rows: Mapping[str, Tensor]) -> None:
        """Add rows (1, ...) at the end."""
        import torch

        old = self.tensors
        self.tensors = {name: torch.cat([old[name], row]) if old else row.clone() for name, row in rows.items()}

    def put(self, at: int, rows: Mapping[str, Tensor]) -> None:
        """Overwrite row ``at`` by rows (1, ...)."""
        for name, row in rows.items():
            self.tensors[name][at] = row[0]

    def keep(self, rows: Sequence[int]) -> None:
        """Drop all other rows."""
        self.tensors = {name: tensor[list(rows)] for name, tensor in self.tensors.items()}


class Players:
    """Plays jobs with one policy in a fixed number of environments.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module.
        make_env: makes an environment of ``UcON-v0``; called as often as environments are needed.
        slots: environments played at once. Results can depend on it in their last bits, so it belongs to a run like
            its seed.
        max_steps: episodes are cut off after this many actions.
        keep_frames: True: outcomes keep what the policy saw, as features of its frozen networks.
        precision: of the network's passes; None: float32.
    """

    def __init__(
        self,
        policy: nn.Module,
        make_env: Callable[[], Env],
        slots: int,
        max_steps: int,
        *,
        keep_frames: bool = False,
        precision: dtype | None = None,
    ) -> None:
        self._policy: Any = policy
        self._precision = precision
        self._make_env, self._n_slots, self._max_steps, self._keep = make_env, slots, max_steps, keep_frames
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
        slots, context, state = list[_Slot](), _Batched(), _Batched()
        with torch.inference_mode(), part(what, len(jobs)) as tick:
            for env in self._envs:
                if self._begin(slot := _Slot(env), waiting, chooser):
                    slots.append(slot)
                    context.append(self._tensors(slot.context))
                    state.append(self._policy.initial_state(1))
            while slots:
                still = []
                for row, (slot, logits) in enumerate(zip(slots, self._forward(slots, context, state), strict=True)):
                    done = self._step(slot, chooser.choose(slot.number, len(slot.actions), logits, slot.seen))
                    if done:
                        results[slot.number] = self._result(slot, jobs[slot.number])
                        tick(len(results))
                        if not self._begin(slot, waiting, chooser):
                            continue
                        context.put(row, self._tensors(slot.context))
                        state.put(row, self._policy.initial_state(1))
                    still.append(row)
                if len(still) < len(slots):
                    context.keep(still)
                    state.keep(still)
                    slots = [slots[row] for row in still]
        self._policy.train(was_training)
        return [results[number] for number in range(len(jobs))]

    def close(self) -> None:
        """Close the environments; a later call makes new ones."""
        while self._envs:
            self._envs.pop().close()

    def _begin(self, slot: _Slot, waiting: Iterator[tuple[int, Job]], chooser: Chooser) -> bool:
        """Reset a slot to the next job; False where no job is left."""
        number, job = next(waiting, (-1, None))
        if job is None:
            return False
        options = {"episode": job.episode, "habit_level": job.level}
        observation, told = slot.env.reset(seed=0, options=options)
        slot.seen = led(slot.env, job.led, Seen(observation, told))
        slot.number, slot.actions, slot.frames, slot.rewards, slot.values = number, [], [], [], []
        slot.context = self._policy.context(told)
        chooser.begin(number, job, slot.env, told)
        return True

    def _forward(self, slots: Sequence[_Slot], context: _Batched, state: _Batched) -> NDArray[np.float64]:
        """Logits (B, 7) of the next step of B slots; updates the recurrent states."""
        import torch

        frames = [self._policy.frame(*slot.seen) for slot in slots]
        device = next(self._policy.parameters()).device
        steps = {
            name: torch.from_numpy(np.stack([np.asarray(frame[name]) for frame in frames])).to(device)[None]
            for name in frames[0]
        }  # (1, B, ...)
        seen = self._policy.features(steps)
        if self._keep:
            if seen is not steps:  # kept, so that frozen networks compute them only once
                arrays = {name: made[0].cpu().numpy() for name, made in seen.items()}
                frames = [{name: array[row] for name, array in arrays.items()} for row in range(len(slots))]
            for slot, frame in zip(slots, frames, strict=True):
                slot.frames.append(frame)
        with torch.autocast(device.type, self._precision, enabled=self._precision not in (None, torch.float32)):
            outputs = self._policy(seen, context.tensors, state.tensors)
        state.tensors = dict(outputs.state)
        if self._keep:
            for slot, value in zip(slots, outputs.value[0].tolist(), strict=True):
                slot.values.append(value)
        return rounded_logits(outputs.logits[0])

    def _step(self, slot: _Slot, action: int) -> bool:
        """Take an action in a slot; True where its episode is over or cut off."""
        slot.actions.append(action)
        observation, reward, terminated, truncated, info = slot.env.step(action)
        slot.seen = Seen(observation, info)
        slot.rewards.append(float(reward))
        return bool(terminated or truncated) or len(slot.actions) >= self._max_steps

    def _result(self, slot: _Slot, job: Job) -> RolloutOutcome:
        metrics = slot.seen.info.get("episode_metrics", {})
        actions = "".join(map(str, slot.actions))
        success, spl = bool(metrics.get("success", False)), float(metrics.get("spl", 0.0))
        return RolloutOutcome(job, actions, success, spl, slot.replay() if self._keep else None, tuple(slot.values))

    def _tensors(self, arrays: Arrays) -> dict[str, Tensor]:
        """Arrays of one episode as tensors (1, ...)."""
        made = tensors_of(arrays, next(self._policy.parameters()).device)
        return {name: tensor[None] for name, tensor in made.items()}
