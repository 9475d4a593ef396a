"""``learner=dagger``: a policy plays, an expert says what it should have done, and it learns from all of that (DAgger).

Imitation shows only what lies along shortest paths; a policy that strays from them has never seen what to do. Every
``per_iteration`` steps some episodes are played by a mixture of policy and expert, all of their steps are labelled by
the expert (:mod:`ucon.task.expert`), and they join what was collected before. After Ross, Gordon and Bagnell (2011).

What was collected is part of the state, as strings of digits; it is played again to be seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream
from ucon.learning.imitation.learner import ImitationLearner
from ucon.learning.imitation.trajectories import NO_LABEL, Trajectory, trajectories_from_json
from ucon.learning.policies.playing import Job, Players, PolicyChooser
from ucon.learning.run.protocol import State
from ucon.task.actions import Action
from ucon.task.expert import Expert


@dataclass(frozen=True)
class Collections:
    """How much is collected, and who plays.

    Raises:
        ConfigError: a number out of range.
    """

    per_iteration: int = 200
    """Steps of learning between two collections."""
    episodes: int = 200
    """Episodes of one collection."""
    mixture: float = 0.5
    """The expert's share of the actions falls by this factor with each collection; the first is the expert's alone."""
    max_steps: int = 200
    """Episodes are cut short here."""
    slots: int = 20
    """Episodes played at once."""
    sample: bool = True
    """Draw the policy's actions by their probabilities in place of the best."""

    def __post_init__(self) -> None:
        for name in ("per_iteration", "episodes", "max_steps", "slots"):
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be a whole number from 1 up")
        if type(self.mixture) not in (int, float) or not 0 <= self.mixture <= 1:
            raise ConfigError(f"learner.rollouts.mixture={brief(self.mixture)}: must be from 0 to 1")


class DaggerLearner(ImitationLearner):
    """See the module.

    Args:
        rollouts: what is collected.
        options: those of :class:`ucon.learning.imitation.learner.ImitationLearner`.
    """

    title = "DAgger"

    def __init__(self, rollouts: Collections, **options: Any) -> None:
        if options.pop("demonstrator", None) is not None:
            raise ConfigError("learner.demonstrator: for learner=imitation; DAgger's expert corrects what is played")
        super().__init__(**options)
        self.rollouts = rollouts
        self.collected: list[Trajectory] = []

    @property
    def iteration(self) -> int:
        """Number of the collection that the next step learns from, from 0."""
        return self.done // self.rollouts.per_iteration

    @property
    def n_labels(self) -> int:
        """Different labelled frames so far."""
        return sum(trajectory.n_labels for trajectory in self.collected)

    def batches(self) -> Iterator[list[Trajectory]]:
        """What the steps until the next collection learn from: at each, some of all that was collected."""
        for step in range(self.done, (self.iteration + 1) * self.rollouts.per_iteration):
            draw = stream(self.seed, "batch", step)
            count = min(self.batch, len(self.collected))
            yield [self.collected[int(k)] for k in draw.choice(len(self.collected), count, replace=False)]

    def step(self) -> dict[str, float]:
        """One batch, after a collection where one is due."""
        if self.done % self.rollouts.per_iteration == 0:
            self._collect()
        return super().step() | {"collected": float(len(self.collected))}

    def state_dict(self) -> State:
        """That of imitation, and what was collected."""
        state = super().state_dict()
        return replace(state, values={**state.values, "collected": [t.to_json() for t in self.collected]})

    def load_state_dict(self, state: State) -> None:
        """Go on after ``done`` steps."""
        super().load_state_dict(state)
        by_id = {episode.id: episode for episode in self.episodes}
        self.collected = trajectories_from_json(state.values.get("collected"), by_id)

    def close(self) -> None:
        """See :class:`ucon.learning.run.protocol.Learner`."""
        super().close()
        self._strays.close()

    @cached_property
    def _strays(self) -> Players:
        return Players(self.policy, self.make_env, self.rollouts.slots, self.rollouts.max_steps)

    def _collect(self) -> None:
        """Play the next episodes. Depends on the weights, the seed and the number of the collection alone."""
        first = self.iteration * self.rollouts.episodes
        jobs = [Job(*self.assigned(first + k)) for k in range(self.rollouts.episodes)]
        share = self.rollouts.mixture**self.iteration
        chooser = _Mixture(share, PolicyChooser(self.rollouts.sample, self.seed, "stray", self.iteration), self)
        with self.updates.averaged():
            played = self._strays.play(jobs, chooser, "collecting")
        labels = chooser.labels
        self.collected += [
            Trajectory(one.job.episode, one.job.level, one.actions, "".join(labels[number]))
            for number, one in enumerate(played)
        ]
        self._stream = None


class _Mixture:
    """Sometimes the expert's action, else the policy's; notes what the expert would do.

    Done where it would fail is not carried out, since nothing would follow from it: the expert's action is.
    """

    def __init__(self, share: float, policy: PolicyChooser, learner: DaggerLearner) -> None:
        self._share, self._policy = share, policy
        self._seed, self._iteration = learner.seed, learner.iteration
        self._experts: dict[int, Expert] = {}
        """By environment: an expert is large, and nobody needs those of episodes that are over."""
        self._envs: dict[int, Any] = {}
        self.labels: dict[int, list[str]] = {}

    def begin(self, number: int, job: Job, env: Any) -> None:
        self.labels[number], self._envs[number] = [], env
        self._experts[id(env)] = Expert(job.episode)

    def choose(self, number: int, step: int, logits: NDArray[np.float64]) -> int:
        env = self._envs[number]
        best = self._experts[id(env)].action(env.unwrapped.search)
        self.labels[number].append(NO_LABEL if best is None else str(int(best)))
        own = self._policy.choose(number, step, logits)
        if best is None:
            return own
        follow = stream(self._seed, "mixture", self._iteration, number, step).random() < self._share
        too_early = own == Action.DONE and best != Action.DONE
        return int(best) if follow or too_early else own
