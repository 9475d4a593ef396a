"""``learner=foresight``: a network that scores views learns by how much each view shortens the way to the target.

It learns from labelled decisions of searches in training homes (:mod:`ucon.learning.foresight.store`), none of which
it plays itself. A step depends only on seed and number, so a resumed run repeats an uninterrupted one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor, nn

from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DivergedError
from ucon.core.rng import stream
from ucon.habits.splits import entry_parts
from ucon.learning.foresight.batches import batch_of, mirrored
from ucon.learning.foresight.decisions import Decisions
from ucon.learning.foresight.store import kept_decisions, store_hash
from ucon.learning.policies.action_policy import scores_views
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.ppo.foresight import progress
from ucon.learning.run.counted_steps import CountedSteps
from ucon.learning.run.network_files import load_network, network_files
from ucon.learning.run.option_checks import check_parts
from ucon.learning.run.options import ForesightOptions
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.updates import Updates
from ucon.task.sets import load_episodes


class ForesightLearner(CountedSteps):
    """Trains the foresight of a network that scores views (see the module).

    Args:
        policy: the network, such as :class:`models.habit_policy.HabitPolicy`; training starts from its present weights.
        searches: make environments of ``UcONSearch-v0`` with ``distance_to_goal=True``, by name; each has a detector.
        options: fields of :class:`ucon.learning.run.options.ForesightOptions`.

    Raises:
        ConfigError: a value of the wrong type or out of range, a network that scores no views, or episodes outside the
            ``train`` part.
        DataError: ``initial`` holds no weights, or those of another network.
    """

    options_of = ForesightOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(self, policy: nn.Module, searches: Mapping[str, Callable[[], Any]], **options: Any) -> None:
        self.options = given = ForesightOptions(**options)
        if not scores_views(policy):
            raise ConfigError("learner=foresight: expected a policy that scores views, such as agent=habit_policy")
        if not searches:
            raise ConfigError("learner.searches={}: expected at least one way to search")
        self.device = torch_device(given.device, "learner.device")
        self._initial = "" if given.initial is None else load_network(str(given.initial), cast(Any, policy))
        self.network, self._makers = policy, tuple(searches.values())
        env = self._makers[0]()
        self.dataset = env.source.dataset
        env.close()
        check_parts(load_episodes(given.episodes), load_episodes(given.validation), entry_parts(self.dataset))
        self.policy = ViewPolicy(policy).to(self.device)
        self.updates = Updates(
            policy, lr=given.lr, clip=given.clip, steps=given.steps, warm_up=given.warm_up, decay=given.decay,
            average=given.average,
        )  # fmt: skip

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the decisions and, if given, of the initial weights."""
        o = self.options
        decisions = f"{store_hash(o.episodes, self._makers, o.levels, 0)} {o.n_searches}"
        return {"decisions": decisions, **({"initial": self._initial} if self._initial else {})}

    @property
    def resolved_options(self) -> Mapping[str, str]:
        """Value chosen for ``device`` where it is ``auto``; the run stores it."""
        return {"device": self.device}

    @cached_property
    def decisions(self) -> Decisions:
        """Training decisions; played at first use, which takes most of the time."""
        return self._kept(self.options.episodes, self.options.n_searches)

    @cached_property
    def validation(self) -> Decisions:
        """Decisions in homes that are not trained on."""
        return self._kept(self.options.validation, self.options.validation_searches)

    def _kept(self, episodes: str, searches: int) -> Decisions:
        return kept_decisions(episodes, searches, self._makers, self.options.levels, 0, self.options.workers)

    def step(self) -> Figures:
        """Update the network on one batch of decisions.

        Returns:
            ``loss``, mean squared error of the progress per move, with ``gradient`` and ``rate``.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        draw = stream(self.options.seed, "foresight", self._done)
        rows = draw.integers(len(self.decisions), size=self.options.batch)
        frames = batch_of(self.decisions, rows)
        if self.options.mirror and draw.random() < 0.5:
            frames = mirrored(frames)
        self.network.train()
        self.updates.begin()
        foreseen, truth, known = self._foreseen(frames)
        loss = ((foreseen - truth) ** 2)[known].mean()
        if not bool(torch.isfinite(loss)):
            raise DivergedError(f"step {self._done + 1}: the loss is not finite; start anew with a smaller learner.lr")
        loss.backward()  # type: ignore[no-untyped-call]
        updated = self.updates.take(self._done)
        self._done += 1
        return {"loss": float(loss.detach()), **updated}

    def _foreseen(self, frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
        """Predicted and true progress (n, V), and where the truth is known (n, V) bool."""
        moved = {name: tensor.to(self.device) for name, tensor in frames.items()}
        foresight = self.policy({name: tensor[None] for name, tensor in moved.items()}, {}, {}).foresight
        assert foresight is not None
        return foresight[0].float(), *progress(moved)

    def validate(self) -> Figures:
        """Figures of the averaged network in homes that it was not trained on.

        ``foreseen``: share of variance of the progress that is explained; ``foreseen_within``: of its variance among
        the views of a decision, which is what a choice turns on. ``score`` is ``foreseen_within``.
        """
        n, total, squares, off, spread_within, off_within = np.zeros(6)
        every, batch = len(self.validation), self.options.batch
        self.network.eval()
        with self.updates.averaged(), torch.no_grad():
            for first in range(0, every, batch):
                rows = np.arange(first, min(first + batch, every))
                foreseen, truth, known = self._foreseen(batch_of(self.validation, rows))
                n, total = n + float(known.sum()), total + float(truth[known].sum())
                squares += float((truth**2)[known].sum())
                off += float(((foreseen - truth) ** 2)[known].sum())
                spread_within += float((_centred(truth, known) ** 2).sum())
                off_within += float((_centred(foreseen - truth, known) ** 2).sum())
        whole = 1.0 - off / max(squares - total**2 / max(n, 1.0), 1e-9)
        within = 1.0 - off_within / max(spread_within, 1e-9)
        return {"foreseen": round(whole, 5), "foreseen_within": round(within, 5), "score": within}

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all, from the next step on."""
        return self.updates.lengthen(steps)

    def product(self) -> Mapping[str, bytes]:
        """Files of the averaged network, by name, as the agent that plays it loads them.

        Raises:
            DataError: a weight that is not finite.
        """
        with self.updates.averaged():
            return network_files(cast(Any, self.network))

    def close(self) -> None:
        """Nothing to close: worker processes end with the collection."""

    def card(self) -> Card:
        """Text of the model card: architecture, size, training data, and how to use the weights."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        name = str(cast(Any, self.network).architecture)
        return Card(
            f"Policy {name}: foresight of the way",
            f"`{name}`, {size:,} parameters. Learned by how much each view shortens the way to the target, from "
            f"{len(self.decisions):,} decisions of {self.options.n_searches:,} searches by gain over cost in "
            f"`{self.options.episodes}` homes; habit levels {', '.join(self.options.levels)}.\n\n"
            f"Use: `python eval.py agent={name} agent.checkpoint=RUN`.",
            self.dataset.name,
        )


def _centred(values: Tensor, known: Tensor) -> Tensor:
    """Values (n, V) less their mean over the known views of each decision; 0 where unknown."""
    count = known.sum(1, keepdim=True).clamp(min=1)
    mean = torch.where(known, values, 0.0).sum(1, keepdim=True) / count
    return torch.where(known, values - mean, 0.0)
