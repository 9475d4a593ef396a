"""``learner=dagger``: the policy plays episodes, an expert labels every step, and the policy learns from all labels.

Plain imitation shows only states along shortest paths; a policy that leaves them has never seen what to do next. Every
``per_iteration`` steps, a mixture of policy and expert plays some episodes, the expert labels every step, and these
trajectories join those collected before (DAgger: Ross, Gordon and Bagnell 2011). The expert either knows the home, or
is an agent that searches with what the policy sees (:mod:`ucon.learning.imitation.experts`).

When collections are played, and with which weights: :mod:`ucon.learning.imitation.collecting_learner`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from torch import Tensor, dtype

from ucon.core.device import torch_precision
from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream
from ucon.learning.imitation.collecting import CollectionPart, Collector
from ucon.learning.imitation.collecting_learner import CollectingLearner
from ucon.learning.imitation.experts import Corrector, KnowingExpert
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.rollouts import Rollouts
from ucon.learning.imitation.trajectories import Trajectory
from ucon.learning.policies.playing import Job
from ucon.learning.run.options import DaggerOptions


@dataclass(frozen=True)
class DaggerRollouts(Rollouts):
    """How many episodes one DAgger collection plays, and with which mixture of policy and expert.

    Raises:
        ConfigError: a number out of range.
    """

    per_iteration: int = 200
    """Learning steps between two collections."""
    newest: float = 0.5
    """Share of each step's episodes that are from the newest collection; the others are from all."""
    mixture: float = 0.5
    """The expert acts with probability ``mixture ** iteration``: 1 in the first collection, then less each time."""
    least: float = 0.0
    """Least probability with which the expert acts."""
    temperature: float = 1.0
    """The policy's actions are sampled at this temperature; 0: the action with the highest logit."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require_counts("per_iteration")
        self.require_shares("mixture", "least", "newest")
        if type(self.temperature) not in (int, float) or not 0 <= self.temperature <= 100:
            raise ConfigError(f"learner.rollouts.temperature={brief(self.temperature)}: must be from 0 to 100")


class DaggerLearner(CollectingLearner):
    """Imitation learner whose expert labels the states that the policy itself reaches (see the module).

    Args:
        rollouts: how much is collected, and with which mixture.
        expert: labels what the policy does; by default one that knows where the target is.
        options: arguments of :class:`ucon.learning.imitation.learner.ImitationLearner`, without ``demonstrator``.

    Raises:
        ConfigError: a ``demonstrator`` is given, or whatever the base class refuses.
    """

    title = "DAgger"

    options_of = DaggerOptions

    rollouts: DaggerRollouts

    def __init__(self, rollouts: DaggerRollouts, expert: Corrector | None = None, **options: Any) -> None:
        if options.pop("demonstrator", None) is not None:
            raise ConfigError("learner.demonstrator: only for learner=imitation; DAgger has its own expert")
        self.expert = expert or KnowingExpert()
        super().__init__(rollouts, **options)

    @property
    def per_iteration(self) -> int:
        """Learning steps between two collections."""
        return self.rollouts.per_iteration

    @property
    def identity(self) -> Mapping[str, str]:
        """As for imitation, and ``expert`` if its labels depend on anything besides the episodes."""
        shown = self.expert.fingerprint()
        return {**super().identity, **({"expert": shown} if shown else {})}

    @property
    def teacher(self) -> str:
        """The expert in words, for the model card."""
        return self.expert.title

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

    def parts(self, iteration: int, jobs: Sequence[Job], weights: Mapping[str, Tensor]) -> Sequence[CollectionPart]:
        """Parts of as many episodes as are played at once."""
        rollouts = self.rollouts
        share = max(rollouts.mixture**iteration, rollouts.least)
        return [
            CollectionPart(
                iteration, at, tuple(jobs[at : at + rollouts.slots]), weights, share, rollouts.temperature, self.seed
            )
            for at in range(0, len(jobs), rollouts.slots)
        ]

    def keep(self, made: Sequence[Trajectory]) -> None:
        """Add the trajectories of a collection; none are ever dropped."""
        self.collected += made

    @property
    def resolved_options(self) -> Mapping[str, str | int]:
        """As for other learners that collect, and ``play_precision``."""
        return {**super().resolved_options, "play_precision": str(self._play_precision).removeprefix("torch.")}

    @property
    def _play_precision(self) -> dtype:
        return torch_precision(cast(DaggerOptions, self.options).play_precision, self.play_device, on_cpu=True)

    def _made_feeder(self, **options: Any) -> Feeder:
        rollouts = self.rollouts
        collector = Collector(
            copy.deepcopy(self.policy).cpu(), self.make_env, self.expert, rollouts.slots, rollouts.max_steps,
            self.play_device, self._play_precision,
        )  # fmt: skip
        return super()._made_feeder(collector=collector, **options)
