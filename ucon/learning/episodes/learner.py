"""``learner=ppo_episodes``: PPO on whole episodes, for policies over the seven actions with a large memory.

``learner=ppo`` stores the recurrent state of every step, so that updates can begin anywhere; the state of a policy with
a map takes a megabyte. Here a collection consists of whole episodes, which workers play, many at once, while the policy
learns from the last collection. An update reads each episode from its beginning, as imitation does
(:mod:`ucon.learning.policies.sequences`).
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from torch import Tensor

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.learning.episodes.collecting import EpisodeCollector, EpisodePart, EpisodeRollouts
from ucon.learning.episodes.experience import (
    Experience,
    compared,
    experience_from_json,
    normalised,
    with_experience,
)
from ucon.learning.imitation.collecting_learner import CollectingLearner
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.trajectories import Replay, Trajectory
from ucon.learning.policies.playing import Job
from ucon.learning.policies.sequences import Batch
from ucon.learning.ppo.clipped_loss import eval_mode_except_rnn
from ucon.learning.ppo.own_play_card import own_play_card
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.trainer_state import SCORE
from ucon.task.episode import Episode


class EpisodePPOLearner(CollectingLearner):
    """Proximal policy optimisation of a policy over the seven actions on whole episodes (see the module).

    Args:
        rollouts: how much is collected, and how it is learned from.
        options: arguments of :class:`ucon.learning.imitation.learner.ImitationLearner`, without ``demonstrator``; the
            loss is an :class:`ucon.learning.episodes.loss.EpisodeLoss`.

    Raises:
        ConfigError: a ``demonstrator`` is given, a validation figure that is not played, or whatever the base class
            refuses.
    """

    title = "proximal policy optimisation on whole episodes"

    rollouts: EpisodeRollouts

    def __init__(self, rollouts: EpisodeRollouts, **options: Any) -> None:
        if options.pop("demonstrator", None) is not None:
            raise ConfigError("learner.demonstrator: only for learner=imitation; PPO learns from its own play")
        super().__init__(rollouts, **options)
        if self.validation.choose not in ("success_rate", "spl"):
            raise ConfigError(f"learner.validation.choose={self.validation.choose}: expected success_rate or spl")
        self._new: Figures = {}
        """Figures of the newest collection, until they are logged."""

    @property
    def per_iteration(self) -> int:
        """Learning steps between two collections: all its episodes ``epochs`` times."""
        return self.rollouts.epochs * -(-self.rollouts.episodes // self.batch)

    def job(self, item: int) -> Job:
        """Episode ``item``, from 0, of all that are ever collected: each is played ``repeats`` times."""
        return super().job(item // self.rollouts.repeats)

    def weights_that_play(self) -> dict[str, Tensor]:
        """A copy of the present weights and buffers, on the CPU: PPO learns from *their* actions, not the average's."""
        return {name: value.detach().cpu().clone() for name, value in self.policy.state_dict().items()}

    def parts(self, iteration: int, jobs: Sequence[Job], weights: Mapping[str, Tensor]) -> Sequence[EpisodePart]:
        """Parts of as many episodes as are played at once."""
        slots = self.rollouts.slots
        return [
            EpisodePart(iteration, at, tuple(jobs[at : at + slots]), weights, self.seed)
            for at in range(0, len(jobs), slots)
        ]

    def keep(self, made: Sequence[Experience]) -> None:
        """Learn from the newest collection alone."""
        explained, given = _explained(made), self.rollouts
        better = compared(made, given.repeats, given.compare) if given.repeats > 1 else made
        self.collected = list(normalised(better))
        self._new = {
            "success_rate": float(np.mean([one.success for one in made])),
            "spl": float(np.mean([one.spl for one in made])),
            "steps": float(np.mean([len(one.actions) for one in made])),
            **({} if explained is None else {"explained": explained}),
        }

    def read(self, rows: Any, episodes: Mapping[str, Episode]) -> list[Trajectory]:
        """Read the experience in a state, which is not trusted."""
        return list(experience_from_json(rows, episodes))

    def batches(self) -> Iterator[Sequence[Trajectory | Job]]:
        """Episodes of each step until the next collection: all of them in another order in every epoch."""
        per_epoch = -(-self.rollouts.episodes // self.batch)
        for step in range(self.done, (self.iteration + 1) * self.per_iteration):
            epoch, number = divmod(step % self.per_iteration, per_epoch)
            order = stream(self.seed, "minibatches", self.iteration, epoch).permutation(len(self.collected))
            yield [self.collected[int(k)] for k in np.array_split(order, per_epoch)[number]]

    def prepared(self, pairs: list[tuple[Trajectory, Replay]]) -> list[tuple[Trajectory, Replay]]:
        """The pairs with log-probabilities, advantages and targets among the frames."""
        return [(one, with_experience(replay, cast(Experience, one))) for one, replay in pairs]

    def augment(self, batch: Batch, seed: int) -> None:
        """Do nothing: augmentation would change the probabilities of the recorded actions."""

    def train_mode(self) -> None:
        """Put the policy into the mode in which it plays, so that ratios of probabilities begin at 1."""
        eval_mode_except_rnn(self.policy)

    def step(self) -> dict[str, float]:
        """Update the policy on one batch; where a collection is due, wait for it first, and ask for the next one.

        Returns:
            The figures of the loss, ``gradient``, ``rate`` and ``frames``; after a new collection also its mean
            ``success_rate``, ``spl`` and ``steps``, and ``explained``, the share of the variance of the value's targets
            that the value had predicted.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        figures = super().step() | self._new
        self._new = {}
        return {name: figure for name, figure in figures.items() if name not in ("labels", "collected")}

    def validate(self) -> Figures:
        """SR, SPL and mean ``steps`` of the averaged policy's play on validation episodes, and ``score``."""
        with self.updates.averaged():
            self.policy.eval()
            found = self.validation.played(self.players, self.seed)
        return found | {SCORE: found[self.validation.choose]}

    def card(self) -> Card:
        """Text of the model card: architecture, size, training episodes, levels and how to use the weights."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        name = self.act.architecture
        return own_play_card(
            f"Policy over the seven actions: {name}, by {self.title}", name, size,
            frames=self.frames, episodes=len(self.episodes), levels=self.levels, dataset=self.dataset.name,
        )  # fmt: skip

    def _collect(self, iteration: int) -> None:
        """Collect, and forget what was seen in earlier collections."""
        self.feeder.forget()
        super()._collect(iteration)

    def _made_feeder(self, **options: Any) -> Feeder:
        collector = EpisodeCollector(copy.deepcopy(self.policy).cpu(), self.make_env, self.rollouts, self.play_device)
        return super()._made_feeder(collector=collector, **options)


def _explained(made: Sequence[Experience]) -> float | None:
    """Share of the variance of the value's targets that the value had predicted; None if all targets are equal."""
    targets = np.concatenate([one.target for one in made]).astype(np.float64)
    surprises = np.concatenate([one.advantage for one in made]).astype(np.float64)
    return float(1 - surprises.var() / targets.var()) if targets.var() > 0 else None
