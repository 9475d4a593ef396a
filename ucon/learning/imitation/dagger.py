"""``learner=dagger``: the policy plays episodes, an expert labels every step, and the policy learns from all labels.

Plain imitation shows only states along shortest paths; a policy that leaves them has never seen what to do next. Every
``per_iteration`` steps, a mixture of policy and expert plays some episodes, the expert labels every step, and these
trajectories join those collected before (DAgger: Ross, Gordon and Bagnell 2011). The expert knows the home, or searches
as an agent that sees what the policy sees (:mod:`ucon.learning.imitation.experts`).

The collected trajectories are part of the learner's state, stored as strings of action digits. Their frames are not
stored; they are made by playing the actions again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream
from ucon.learning.imitation.experts import Corrector, KnowingExpert
from ucon.learning.imitation.learner import ImitationLearner
from ucon.learning.imitation.trajectories import NO_LABEL, Trajectory, trajectories_from_json
from ucon.learning.policies.playing import Job, Players, PolicyChooser, Seen
from ucon.learning.run.protocol import State
from ucon.task.actions import Action


@dataclass(frozen=True)
class DaggerRollouts:
    """How many episodes one DAgger collection plays, and with which mixture of policy and expert.

    Raises:
        ConfigError: a number out of range.
    """

    per_iteration: int = 200
    """Learning steps between two collections."""
    episodes: int = 200
    """Episodes of one collection."""
    mixture: float = 0.5
    """The expert acts with probability ``mixture ** iteration``: 1 in the first collection, then less each time."""
    max_steps: int = 200
    """Episodes are cut off after this many actions."""
    slots: int = 20
    """Episodes played in parallel."""
    sample: bool = True
    """True: sample the policy's actions from its probabilities. False: take the action with the highest logit."""

    def __post_init__(self) -> None:
        for name in ("per_iteration", "episodes", "max_steps", "slots"):
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be a whole number from 1 up")
        if type(self.mixture) not in (int, float) or not 0 <= self.mixture <= 1:
            raise ConfigError(f"learner.rollouts.mixture={brief(self.mixture)}: must be from 0 to 1")


class DaggerLearner(ImitationLearner):
    """Imitation learner that collects its own trajectories (see the module).

    Args:
        rollouts: how much is collected, and with which mixture.
        expert: labels what the policy does; by default one that knows where the target is.
        options: arguments of :class:`ucon.learning.imitation.learner.ImitationLearner`, without ``demonstrator``.

    Raises:
        ConfigError: a ``demonstrator`` is given, or whatever the base class refuses.
    """

    title = "DAgger"

    def __init__(self, rollouts: DaggerRollouts, expert: Corrector | None = None, **options: Any) -> None:
        if options.pop("demonstrator", None) is not None:
            raise ConfigError("learner.demonstrator: for learner=imitation; DAgger's expert corrects what is played")
        super().__init__(**options)
        self.rollouts, self.expert = rollouts, expert or KnowingExpert()
        self.collected: list[Trajectory] = []

    @property
    def identity(self) -> Mapping[str, str]:
        """As of imitation, and the ``expert``, where it has anything of its own."""
        shown = self.expert.fingerprint()
        return {**super().identity, **({"expert": shown} if shown else {})}

    @property
    def teacher(self) -> str:
        """Who says what to do, in words."""
        return self.expert.title

    @property
    def iteration(self) -> int:
        """Number of the collection that the next step learns from, from 0."""
        return self.done // self.rollouts.per_iteration

    @property
    def n_labels(self) -> int:
        """Number of labelled frames collected so far; each is counted once, however often it is trained on."""
        return sum(trajectory.n_labels for trajectory in self.collected)

    def batches(self) -> Iterator[Sequence[Trajectory | Job]]:
        """Trajectories of each step until the next collection.

        Yields:
            For each step, ``batch`` trajectories drawn without replacement from all that were collected. The draw is a
            function of seed and step.
        """
        for step in range(self.done, (self.iteration + 1) * self.rollouts.per_iteration):
            draw = stream(self.seed, "batch", step)
            count = min(self.batch, len(self.collected))
            yield [self.collected[int(k)] for k in draw.choice(len(self.collected), count, replace=False)]

    def step(self) -> dict[str, float]:
        """Update the policy on one batch; play a new collection first where one is due.

        Returns:
            The figures of imitation, and ``collected``: the number of trajectories so far.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        if self.done % self.rollouts.per_iteration == 0:
            self._collect()
        return super().step() | {"collected": float(len(self.collected))}

    def state_dict(self) -> State:
        """State of the imitation learner, with the collected trajectories as plain values."""
        state = super().state_dict()
        return replace(state, values={**state.values, "collected": [t.to_json() for t in self.collected]})

    def load_state_dict(self, state: State) -> None:
        """Restore counters, weights, optimiser moments and collected trajectories.

        Raises:
            DataError: a state of another network, or trajectories of other episodes.
        """
        super().load_state_dict(state)
        by_id = {episode.id: episode for episode in self.episodes}
        self.collected = trajectories_from_json(state.values.get("collected"), by_id)

    def close(self) -> None:
        """End worker processes and close all environments, those of the collections too."""
        super().close()
        self._rollout_players.close()

    @cached_property
    def _rollout_players(self) -> Players:
        return Players(self.policy, self.make_env, self.rollouts.slots, self.rollouts.max_steps)

    def _collect(self) -> None:
        """Play the next episodes and label every step.

        The result depends only on the weights, the seed and the number of the collection.
        """
        first = self.iteration * self.rollouts.episodes
        jobs = [Job(*self.assigned(first + k)) for k in range(self.rollouts.episodes)]
        share = self.rollouts.mixture**self.iteration
        chooser = _Mixture(share, PolicyChooser(self.rollouts.sample, self.seed, "stray", self.iteration), self)
        with self.updates.averaged():
            played = self._rollout_players.play(jobs, chooser, "collecting")
        labels = chooser.labels
        self.collected += [
            Trajectory(one.job.episode, one.job.level, one.actions, "".join(labels[number]))
            for number, one in enumerate(played)
        ]
        self._stream = None


class _Mixture:
    """Chooses the expert's action with probability ``share``, else the policy's.

    Records the expert's label of every step.

    If the policy says Done where the expert does not, the expert's action is taken: Done would end the episode, and no
    further step could be labelled.
    """

    def __init__(self, share: float, policy: PolicyChooser, learner: DaggerLearner) -> None:
        self._share, self._policy, self._expert = share, policy, learner.expert
        self._seed, self._iteration = learner.seed, learner.iteration
        self._slot: dict[int, int] = {}
        """Slot of each job, by number: one for each environment."""
        self._number: dict[int, int] = {}
        self.labels: dict[int, list[str]] = {}

    def begin(self, number: int, job: Job, env: Any, info: Mapping[str, Any]) -> None:
        self.labels[number] = []
        self._slot[number] = self._number.setdefault(id(env), len(self._number))
        self._expert.begin(self._slot[number], job.episode, env, info)

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        best = self._expert.label(self._slot[number], *seen)
        self.labels[number].append(NO_LABEL if best is None else str(int(best)))
        own = self._policy.choose(number, step, logits, seen)
        if best is None:
            return own
        take_expert = stream(self._seed, "mixture", self._iteration, number, step).random() < self._share
        too_early = own == Action.DONE and best != Action.DONE
        return int(best) if take_expert or too_early else own
