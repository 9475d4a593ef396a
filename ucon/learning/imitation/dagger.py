"""``learner=dagger``: the policy plays episodes, an expert labels every step, and the policy learns from all labels.

Plain imitation shows only states along shortest paths; a policy that leaves them has never seen what to do next. Every
``per_iteration`` steps, a mixture of policy and expert plays some episodes, the expert labels every step, and these
trajectories join those collected before (DAgger: Ross, Gordon and Bagnell 2011). The expert knows the home, or searches
as an agent that sees what the policy sees (:mod:`ucon.learning.imitation.experts`).

Workers play the next collection while the policy learns from the last one, so the weights that play are those from when
the last one began to be learned from. They are part of the learner's state, as are the collected trajectories, stored
as strings of action digits. Their frames are kept while there is memory, else made by playing the actions again.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from torch import Tensor

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.progress import part as progress
from ucon.core.rng import stream
from ucon.learning.imitation.collecting import CollectionPart, Collector
from ucon.learning.imitation.experts import Corrector, KnowingExpert
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.learner import ImitationLearner
from ucon.learning.imitation.trajectories import Trajectory, trajectories_from_json
from ucon.learning.policies.playing import Job
from ucon.learning.run.protocol import State
from ucon.learning.run.updates import require_finite

#: Prefix of the names of the weights that play, in the state.
_PLAYING: Final = "playing/"


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
    newest: float = 0.5
    """Share of each step's episodes that are from the newest collection; the others are from all."""
    mixture: float = 0.5
    """The expert acts with probability ``mixture ** iteration``: 1 in the first collection, then less each time."""
    least: float = 0.0
    """But with at least this probability."""
    max_steps: int = 200
    """Episodes are cut off after this many actions."""
    slots: int = 20
    """Episodes played at once, by one process."""
    temperature: float = 1.0
    """The policy's actions are sampled at this temperature; 0: the action with the highest logit."""

    def __post_init__(self) -> None:
        for name in ("per_iteration", "episodes", "max_steps", "slots"):
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be a whole number from 1 up")
        for name in ("mixture", "least", "newest"):
            value = getattr(self, name)
            if type(value) not in (int, float) or not 0 <= value <= 1:
                raise ConfigError(f"learner.rollouts.{name}={brief(value)}: must be from 0 to 1")
        if type(self.temperature) not in (int, float) or not 0 <= self.temperature <= 100:
            raise ConfigError(f"learner.rollouts.temperature={brief(self.temperature)}: must be from 0 to 100")


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
        self.rollouts, self.expert = rollouts, expert or KnowingExpert()
        super().__init__(**options)
        self.collected: list[Trajectory] = []
        self._playing: dict[str, Tensor] = {}
        """Weights that play the next collection."""
        self._ahead: list[Callable[[], list[Trajectory]]] = []
        """Parts of the next collection, once asked for."""
        self._length = self.options.steps

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
            For each step, ``batch`` trajectories drawn without replacement: a share from the newest collection, the
            rest from all. The draw is a function of seed and step.
        """
        newest = self.collected[-self.rollouts.episodes :]
        for step in range(self.done, (self.iteration + 1) * self.rollouts.per_iteration):
            draw = stream(self.seed, "batch", step)
            fresh = min(round(self.batch * self.rollouts.newest), len(newest))
            rest = min(self.batch - fresh, len(self.collected))
            yield [
                *(newest[int(k)] for k in draw.choice(len(newest), fresh, replace=False)),
                *(self.collected[int(k)] for k in draw.choice(len(self.collected), rest, replace=False)),
            ]

    def step(self) -> dict[str, float]:
        """Update the policy on one batch; where a collection is due, wait for it first, and ask for the next one.

        Returns:
            The figures of imitation, and ``collected``: the number of trajectories so far.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        if self.done % self.rollouts.per_iteration == 0:
            self._collect(self.iteration)
            self._playing = self._weights()
        if not self._ahead and (self.iteration + 1) * self.rollouts.per_iteration < self._length:
            self._ahead = self._asked_for(self.iteration + 1)
        return super().step() | {"collected": float(len(self.collected))}

    def state_dict(self) -> State:
        """State of the imitation learner, with the weights that play and the collected trajectories."""
        state = super().state_dict()
        tensors = {**state.tensors, **{f"{_PLAYING}{name}": value for name, value in self._playing.items()}}
        return State(tensors, {**state.values, "collected": [t.to_json() for t in self.collected]})

    def load_state_dict(self, state: State) -> None:
        """Restore counters, weights, optimiser moments and collected trajectories.

        Raises:
            DataError: a state of another network, or trajectories of other episodes.
        """
        playing = {
            name.removeprefix(_PLAYING): value for name, value in state.tensors.items() if name.startswith(_PLAYING)
        }
        learned = {name: value for name, value in state.tensors.items() if not name.startswith(_PLAYING)}
        super().load_state_dict(replace(state, tensors=learned))
        now = self._weights()
        begun = bool(playing) or self.done > 0  # before the first step nothing plays yet
        if begun and {name: tensor.shape for name, tensor in playing.items()} != {n: t.shape for n, t in now.items()}:
            raise DataError("state of another learner: the weights that play are missing, or of another network")
        require_finite(playing, self.done)
        self._playing, self._ahead = playing, []
        by_id = {episode.id: episode for episode in self.episodes}
        self.collected = trajectories_from_json(state.values.get("collected"), by_id)

    def lengthen(self, steps: int) -> bool:
        """As of imitation; collections are asked for until then."""
        self._length = steps
        return super().lengthen(steps)

    def close(self) -> None:
        """End worker processes and close all environments."""
        super().close()
        self._ahead = []

    def _made_feeder(self, **options: Any) -> Feeder:
        rollouts = self.rollouts
        collector = Collector(
            copy.deepcopy(self.policy).cpu(), self.make_env, self.expert, rollouts.slots, rollouts.max_steps
        )
        return super()._made_feeder(collector=collector, **options)

    def _weights(self) -> dict[str, Tensor]:
        """A copy of the averaged weights and of the buffers, on the CPU."""
        with self.updates.averaged():
            return {name: value.detach().cpu().clone() for name, value in self.policy.state_dict().items()}

    def _collect(self, iteration: int) -> None:
        """Add the trajectories of a collection to those collected before.

        They depend only on the weights that play, the seed and the number of the collection.
        """
        if not self._playing:
            self._playing = self._weights()
        parts, found = self._ahead or self._asked_for(iteration), 0
        for part in parts:
            made = part()  # where this process plays it, it shows its own progress
            self.collected += made
            found += len(made)
            with progress("collecting", self.rollouts.episodes) as tick:
                tick(found)
        self._ahead, self._stream = [], None

    def _asked_for(self, iteration: int) -> list[Callable[[], list[Trajectory]]]:
        """Parts of a collection, which workers begin to play."""
        rollouts = self.rollouts
        first = iteration * rollouts.episodes
        jobs = [Job(*self.assigned(first + k)) for k in range(rollouts.episodes)]
        share = max(rollouts.mixture**iteration, rollouts.least)
        return self.feeder.begin_collecting(
            [
                CollectionPart(
                    iteration,
                    at,
                    tuple(jobs[at : at + rollouts.slots]),
                    self._playing,
                    share,
                    rollouts.temperature,
                    self.seed,
                )
                for at in range(0, len(jobs), rollouts.slots)
            ]
        )
