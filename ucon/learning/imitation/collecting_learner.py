"""Learners that collect what they learn from, by playing: workers play the next collection while the policy learns.

A collection is played with the weights that the policy had when it began to learn from the collection before. These
weights are part of the learner's state, as are the collected trajectories, stored as strings. The frames of the
trajectories are kept while there is memory, and otherwise made by playing the actions again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, cast

from torch import Tensor

from ucon.core.device import torch_device
from ucon.core.errors import DataError
from ucon.core.progress import part as progress
from ucon.core.rng import stream
from ucon.learning.imitation.learner import ImitationLearner
from ucon.learning.imitation.rollouts import Rollouts
from ucon.learning.imitation.trajectories import Trajectory, trajectories_from_json
from ucon.learning.policies.playing import Job
from ucon.learning.run.options import CollectingOptions
from ucon.learning.run.protocol import State
from ucon.learning.run.updates import require_finite
from ucon.task.episode import Episode

#: Prefix of the names of the weights that play, in the state.
_PLAYING: Final = "playing/"


class CollectingLearner(ImitationLearner):
    """Imitation learner that collects its own trajectories (see the module).

    Subclasses say how long a collection is learned from (:attr:`per_iteration`), what plays it (:meth:`parts`), and
    what is done with it (:meth:`keep`).

    Args:
        rollouts: how much is collected, and where episodes begin.
        options: arguments of :class:`ucon.learning.imitation.learner.ImitationLearner`.
    """

    options_of = CollectingOptions

    def __init__(self, rollouts: Rollouts, **options: Any) -> None:
        self.rollouts = rollouts
        super().__init__(**options)
        self.collected: list[Trajectory] = []
        self._playing: dict[str, Tensor] = {}
        """Weights that play the next collection."""
        self._ahead: list[Callable[[], list[Any]]] = []
        """Parts of the next collection, once asked for."""
        self._length = self.options.steps

    @property
    def play_device(self) -> str:
        """Device of the policy that plays."""
        return torch_device(cast(CollectingOptions, self.options).play_device, "learner.play_device")

    @property
    def resolved_options(self) -> Mapping[str, str | int]:
        """As for imitation, and ``play_device``."""
        return {**super().resolved_options, "play_device": self.play_device}

    @property
    def per_iteration(self) -> int:
        """Learning steps between two collections."""
        raise NotImplementedError

    def job(self, item: int) -> Job:
        """Episode ``item``, from 0, of all that are ever collected; some begin near the end of their solution."""
        job, draw = Job(*self.assigned(item)), stream(self.seed, "backplay", item)
        if draw.random() >= self.rollouts.backplay:
            return job
        left = int(draw.integers(1, self.rollouts.backplay_steps, endpoint=True))
        return replace(job, led=job.episode.solution[:-left])

    def parts(self, iteration: int, jobs: Sequence[Job], weights: Mapping[str, Tensor]) -> Sequence[Any]:
        """A collection cut into parts, as the feeder's collector plays them.

        Args:
            iteration: number of the collection, from 0.
            jobs: its episodes.
            weights: of the policy that plays.
        """
        raise NotImplementedError

    def keep(self, made: Sequence[Any]) -> None:
        """Add the trajectories of a collection to those that are learned from."""
        raise NotImplementedError

    def weights_that_play(self) -> dict[str, Tensor]:
        """A copy of the averaged weights and of the buffers, on the CPU."""
        with self.updates.averaged():
            return {name: value.detach().cpu().clone() for name, value in self.policy.state_dict().items()}

    @property
    def iteration(self) -> int:
        """Number of the collection that the next step learns from, from 0."""
        return self.done // self.per_iteration

    def step(self) -> dict[str, float]:
        """Update the policy on one batch; where a collection is due, wait for it first, and ask for the next one.

        Returns:
            The figures of imitation, and ``collected``: the number of trajectories that it learns from.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        if self.done % self.per_iteration == 0:
            self._collect(self.iteration)
            self._playing = self.weights_that_play()
        if not self._ahead and (self.iteration + 1) * self.per_iteration < self._length:
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
        now = self.weights_that_play()
        begun = bool(playing) or self.done > 0  # before the first step nothing plays yet
        if begun and {name: tensor.shape for name, tensor in playing.items()} != {n: t.shape for n, t in now.items()}:
            raise DataError("state of another learner: the weights that play are missing, or of another network")
        require_finite(playing, self.done)
        self._playing, self._ahead = playing, []
        self.collected = self.read(state.values.get("collected"), {episode.id: episode for episode in self.episodes})

    def read(self, rows: Any, episodes: Mapping[str, Episode]) -> list[Trajectory]:
        """Collected trajectories of a state, not trusted; see :func:`trajectories_from_json`."""
        return trajectories_from_json(rows, episodes)

    def lengthen(self, steps: int) -> bool:
        """As for imitation; collections are asked for until then."""
        self._length = steps
        return super().lengthen(steps)

    def close(self) -> None:
        """End worker processes and close all environments."""
        super().close()
        self._ahead = []

    def _collect(self, iteration: int) -> None:
        """Play a collection and keep it.

        It depends only on the weights that play, the seed and the number of the collection.
        """
        if not self._playing:
            self._playing = self.weights_that_play()
        made: list[Any] = []
        for part in self._ahead or self._asked_for(iteration):
            made += part()  # where this process plays it, it shows its own progress
            with progress("collecting", self.rollouts.episodes) as tick:
                tick(len(made))
        self.keep(made)
        self._ahead, self._stream = [], None

    def _asked_for(self, iteration: int) -> list[Callable[[], list[Any]]]:
        """Parts of a collection, which workers begin to play."""
        first = iteration * self.rollouts.episodes
        jobs = [self.job(first + k) for k in range(self.rollouts.episodes)]
        return self.feeder.begin_collecting(self.parts(iteration, jobs, self._playing))
