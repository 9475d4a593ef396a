"""Base of learners from kept decisions: a network that scores views learns from labels of single decisions.

The network makes none of the decisions itself: they are played by gain over cost and labelled once
(:mod:`ucon.learning.decisions.store`). A step depends only on seed and number, so a resumed run repeats an
uninterrupted one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import Any, ClassVar, cast

import numpy as np
import torch
from torch import Tensor, nn

from ucon.core.device import torch_device, torch_precision
from ucon.core.errors import ConfigError, DivergedError
from ucon.core.rng import stream
from ucon.habits.splits import entry_parts
from ucon.learning.decisions.batches import batch_of, mirrored
from ucon.learning.decisions.decisions import Decisions
from ucon.learning.decisions.store import Labels, kept_decisions, store_hash
from ucon.learning.policies.action_policy import PolicyOutputs, scores_views
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.run.counted_steps import CountedSteps
from ucon.learning.run.network_files import load_network, network_files
from ucon.learning.run.option_checks import check_parts
from ucon.learning.run.options import DecisionOptions
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.updates import Updates
from ucon.task.sets import load_episodes


class DecisionLearner(CountedSteps):
    """Trains a network that scores views on labelled decisions (see the module).

    Args:
        policy: the network, such as :class:`models.habit_policy.HabitPolicy`; training starts from its present weights.
        search: makes, with a detector, an environment of ``UcONSearch-v0`` that provides what the labels need.
        detectors: detectors of the searches, by name; each is used in equally many searches.
        options: fields of :class:`ucon.learning.run.options.DecisionOptions`.

    Raises:
        ConfigError: a value of the wrong type or out of range, a network that scores no views, no detector, or episodes
            outside the ``train`` part.
        DataError: ``initial`` holds no weights, or those of another network.
    """

    options_of: ClassVar[type] = DecisionOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""
    #: What is learned, for the model card.
    learns: ClassVar[str]

    def __init__(
        self, policy: nn.Module, search: Callable[..., Any], detectors: Mapping[str, Any], **options: Any
    ) -> None:
        self.options = given = DecisionOptions(**options)
        if not scores_views(policy):
            raise ConfigError(f"learner={self.labels.name}: expected a policy that scores views, as agent=habit_policy")
        if not detectors:
            raise ConfigError("learner.detectors={}: expected at least one detector")
        self.device = torch_device(given.device, "learner.device")
        self._precision = torch_precision(given.precision, self.device, on_cpu=True)
        self._initial = "" if given.initial is None else load_network(str(given.initial), cast(Any, policy))
        self.network, self._makers = policy, [partial(search, detector=one) for one in detectors.values()]
        env = self._makers[0]()
        self.dataset = env.source.dataset
        env.close()
        check_parts(load_episodes(given.episodes), load_episodes(given.validation), entry_parts(self.dataset))
        self.policy = ViewPolicy(policy).to(self.device)
        self.updates = Updates(
            policy, lr=given.lr, clip=given.clip, steps=given.steps, warm_up=given.warm_up, decay=given.decay,
            average=given.average,
        )  # fmt: skip

    labels: Labels
    """Plays the searches and labels their decisions."""

    def loss(self, outputs: PolicyOutputs, frames: Mapping[str, Tensor]) -> Tensor:
        """Loss of n decisions.

        Args:
            outputs: of the network, without the dimension of time.
            frames: of the decisions, with their labels.
        """
        raise NotImplementedError

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the decisions and, if given, of the initial weights."""
        o = self.options
        stores = [store_hash(self.labels, o.episodes, make, o.levels, 0) for make in self._makers]
        decisions = f"{' '.join(stores)} {o.n_searches}"
        return {"decisions": decisions, **({"initial": self._initial} if self._initial else {})}

    @property
    def resolved_options(self) -> Mapping[str, str]:
        """Values chosen for ``device`` and ``precision`` where they are ``auto``; the run stores them."""
        return {"device": self.device, "precision": str(self._precision).removeprefix("torch.")}

    @cached_property
    def decisions(self) -> Decisions:
        """Training decisions; played at first use, which takes most of the time."""
        return self.kept(self.labels, self.options.episodes, self.options.n_searches)

    @cached_property
    def validation(self) -> Decisions:
        """Decisions in homes that are not trained on."""
        return self.kept(self.labels, self.options.validation, self.options.validation_searches)

    def kept(self, labels: Labels, episodes: str, searches: int) -> Decisions:
        """Labelled decisions of some searches, the same number with each detector (or one more).

        Args:
            labels: plays the searches and labels their decisions.
            episodes: name of a set.
            searches: how many in all.
        """
        o, n = self.options, len(self._makers)
        counts = [len(range(k, searches, n)) for k in range(n)]
        parts = zip(self._makers, counts, strict=True)
        return Decisions.join([kept_decisions(labels, episodes, c, m, o.levels, 0, o.workers) for m, c in parts if c])

    def step(self) -> Figures:
        """Update the network on one batch of decisions.

        Returns:
            ``loss``, with ``gradient`` and ``rate``.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        self.network.train()
        self.updates.begin()
        loss = self.loss_of_step(stream(self.options.seed, self.labels.name, self._done))
        if not bool(torch.isfinite(loss)):
            raise DivergedError(
                f"step {self._done + 1}: the loss is not finite; start a new run with a smaller learner.lr"
            )
        loss.backward()  # type: ignore[no-untyped-call]
        updated = self.updates.take(self._done)
        self._done += 1
        return {"loss": float(loss.detach()), **updated}

    def loss_of_step(self, draw: np.random.Generator) -> Tensor:
        """Loss of the batch of one step.

        Args:
            draw: random numbers of the step.
        """
        return self.loss(*self.outputs(self.drawn(self.decisions, draw)))

    def drawn(self, decisions: Decisions, draw: np.random.Generator) -> dict[str, Tensor]:
        """Draw a batch of decisions; with the option ``mirror``, half of all batches are mirrored.

        Args:
            decisions: to take them from.
            draw: random numbers.
        """
        frames = batch_of(decisions, draw.integers(len(decisions), size=self.options.batch))
        return mirrored(frames) if self.options.mirror and draw.random() < 0.5 else frames

    def outputs(self, frames: Mapping[str, Tensor]) -> tuple[PolicyOutputs, Mapping[str, Tensor]]:
        """Outputs of the network for n decisions, and the decisions as tensors on its device."""
        moved = {name: tensor.to(self.device) for name, tensor in frames.items()}
        lower = self._precision != torch.float32 and self.network.training
        with torch.autocast(torch.device(self.device).type, self._precision, enabled=lower):
            found = self.policy({name: tensor[None] for name, tensor in moved.items()}, {}, {})
        foresight = None if found.foresight is None else found.foresight[0].float()
        return PolicyOutputs(found.logits[0].float(), found.value[0].float(), {}, foresight), moved

    def validated(
        self, measure: Callable[[PolicyOutputs, Mapping[str, Tensor]], Mapping[str, float]]
    ) -> dict[str, float]:
        """Sums of the figures of ``measure`` over batches of the validation decisions, with the averaged network."""
        every, batch, sums = len(self.validation), self.options.batch, dict[str, float]()
        self.network.eval()
        with self.updates.averaged(), torch.no_grad():
            for first in range(0, every, batch):
                rows = np.arange(first, min(first + batch, every))
                for name, value in measure(*self.outputs(batch_of(self.validation, rows))).items():
                    sums[name] = sums.get(name, 0.0) + float(value)
        return sums

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
            f"Policy {name}: {self.labels.name}",
            f"`{name}`, {size:,} parameters. Learned {self.learns}, from {len(self.decisions):,} decisions of "
            f"{self.options.n_searches:,} searches by gain over cost in `{self.options.episodes}` homes; habit levels "
            f"{', '.join(self.options.levels)}.\n\nUse: `python eval.py agent={name} agent.checkpoint=RUN`.",
            self.dataset.name,
        )


def centred(values: Tensor, known: Tensor) -> Tensor:
    """Values (n, V) less their mean over the known views of each decision; 0 where unknown."""
    count = known.sum(1, keepdim=True).clamp(min=1)
    mean = torch.where(known, values, 0.0).sum(1, keepdim=True) / count
    return torch.where(known, values - mean, 0.0)
