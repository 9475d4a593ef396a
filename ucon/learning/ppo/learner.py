"""``learner=ppo``: a policy plays and learns from what came of it (PPO), by TorchRL's collectors, advantages and loss.

One step is one collection and a few passes over it. The policy is one over the seven actions, or a network that scores
views, such as the hybrid habit policy. Each collection begins with fresh episodes, drawn with the seed and the number
of the step, so the state between steps is that of the network and its optimiser alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, cast

import torch
from torch import Tensor, nn

from ucon.core.device import torch_device, torch_precision
from ucon.core.errors import DivergedError
from ucon.core.files import sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.core.progress import part, ticked
from ucon.core.rng import derived_seed, stream
from ucon.habits.splits import entry_parts
from ucon.learning.policies.action_policy import ActionPolicy, PolicyOutputs, scores_views
from ucon.learning.policies.playing import Players
from ucon.learning.policies.validation import Validation, evenly_spaced
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.ppo.checks import check_choices, check_taught, collection_size
from ucon.learning.ppo.clipped_loss import PPOLoss, finite, inference_mode_but_memory, total
from ucon.learning.ppo.collecting import Collecting, ExperienceCollector
from ucon.learning.ppo.experience import Experience, Sequences
from ucon.learning.ppo.foresight import TO_GO, ForesightLoss
from ucon.learning.run.network_files import load_network, network_files, set_max_habits
from ucon.learning.run.option_checks import check_parts, text_weights
from ucon.learning.run.options import PPOOptions
from ucon.learning.run.protocol import Card, Figures, State
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.updates import Updates, require_finite
from ucon.task.sets import load_episodes


class PPOLearner:
    """See the module.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a module, or a network that scores
            views; begins with the weights that it has.
        env: makes an environment of ``UcON-v0``; sent to workers.
        search: makes one of ``UcONSearch-v0``, for networks that score views.
        collector: who plays.
        loss: what is learned from a minibatch.
        foresight: what a network that scores views is told of the way; None: nothing.
        validation: how states are compared: by ``success_rate`` or ``spl`` of what is played.
        options: :class:`ucon.learning.run.options.PPOOptions`.

    Raises:
        ConfigError: a value of the wrong type or outside its range, or episodes that must not be learned from.
        DataError: no weights in ``initial``, or those of another network.
    """

    options_of = PPOOptions
    """Whose options it takes beside its own."""

    def __init__(
        self,
        policy: nn.Module,
        env: Callable[[], Any],
        search: Callable[[], Any],
        collector: Collecting,
        loss: PPOLoss,
        validation: Validation,
        foresight: ForesightLoss | None = None,
        **options: Any,
    ) -> None:
        self.options = given = PPOOptions(**options)
        check_choices(policy, validation)
        self.device = torch_device(given.device, "learner.device")
        self._precision = torch_precision(given.precision, self.device)
        self._initial = "" if given.initial is None else load_network(str(given.initial), cast(Any, policy))
        views = scores_views(policy)
        self.policy: nn.Module = ViewPolicy(policy) if views else policy
        self.act, self.network = cast(ActionPolicy, self.policy), policy
        self.make_env = search if views else env
        self.levels = tuple(given.levels) if self.act.uses_habits else ("none",)
        self.episodes = evenly_spaced(load_episodes(given.episodes), given.n_episodes, "learner.n_episodes")
        in_actions, in_views = env(), search() if views else None
        check_taught(policy, in_actions, loss.objective)
        set_max_habits(policy, in_actions.unwrapped)
        self._read_by = str(fingerprint_of(in_views))
        self.source = (in_views or in_actions).unwrapped.source
        self.dataset = self.source.dataset
        check_parts(self.episodes, validation.all, entry_parts(self.dataset))
        self.loss, self.validation, self.seed = loss, validation, given.seed
        self.foresight = foresight if views else None
        self.chunk = given.chunk if self.act.initial_state(1) else 1
        each = -(-collection_size(self.act, given.frames) // collector.rows) + 1  # the last one is not learned from
        self.rollouts = ExperienceCollector(self.policy, self.make_env, self.episodes, self.levels, collector, each)
        self.policy.to(self.device)
        self.updates = Updates(
            self.policy, lr=given.lr, clip=given.clip, steps=given.steps if given.anneal else 0,
            warm_up=given.warm_up, decay=given.decay, average=given.average,
        )  # fmt: skip
        self.done, self.frames = 0, 0

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the episodes, of the habits, of frozen weights and of those that read or rank habits."""
        of_episodes = [f"{e.id} {e.home_hash} {e.solution}" for e in (*self.episodes, *self.validation.all)]
        frozen = fingerprint_of(self.policy)
        text = text_weights(self.source, (*self.levels, self.validation.level))
        hashes = {"habits": self.dataset.sha256, "episodes": sha256_bytes("\n".join(of_episodes).encode())}
        others = {"frozen": frozen, "reader": self._read_by, "initial": self._initial, "text": text}
        return hashes | {name: by for name, by in others.items() if by}

    @property
    def resolved_options(self) -> Mapping[str, str]:
        """What ``auto`` came to here, by option: a run keeps it, wherever it goes on."""
        return {"device": self.device, "precision": str(self._precision).removeprefix("torch.")}

    def step(self) -> Figures:
        """One collection, and what is learned from it.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        with part("collecting"):
            batch = self.rollouts.collect(derived_seed(self.seed, "collect", self.done))
        experience = Experience(batch, self.options.discount, self.options.trace, self.chunk)
        inference_mode_but_memory(self.policy)
        learned: list[Mapping[str, float]] = []
        passes = 0
        for epoch in ticked("updating", range(self.options.epochs)):
            draw = stream(self.seed, "minibatches", self.done, epoch)
            first = len(learned)
            learned += [self._update(some) for some in experience.minibatches(self.options.minibatch, draw)]
            passes += 1
            if total(learned[first:])["kl"] > self.options.kl_stop:
                break
        for frames in experience.seen(self.options.minibatch):
            self.act.update_statistics(_moved(frames, self.device))
        self.done += 1
        self.frames += len(experience)
        figures = experience.figures() | total(learned)
        return figures | {"passes": float(passes), "frames": float(self.frames)}

    def _update(self, part: Sequences) -> Mapping[str, float]:
        """One step of the optimiser."""
        device = self.device
        frames, context, state = (_moved(tensors, device) for tensors in (part.frames, part.context, part.state))
        kind = torch.device(device).type
        with torch.autocast(kind, self._precision, enabled=self._precision != torch.float32):
            outputs = self.act(frames, context, state)
        there = part.there.to(device)
        logits, value = outputs.logits.float()[there], outputs.value.float()[there]
        told = {"logits": logits.masked_fill(logits == -torch.inf, 0.0), "value": value}
        if not all(map(finite, told.values())):  # no loss can be made of them
            self._diverged(frames, told, part)
        loss, figures = self.loss(part.played, logits, value)
        taught, more = self._taught(frames, outputs, there)
        loss, figures = loss + taught, {**figures, **more}
        if not finite(loss):
            self._diverged(frames, told, part)
        self.updates.begin()
        loss.backward()  # type: ignore[no-untyped-call]
        return {"loss": float(loss.detach()), **figures, **self.updates.take(self.done)}

    def _taught(
        self, frames: Mapping[str, Tensor], outputs: PolicyOutputs, there: Tensor
    ) -> tuple[Tensor | float, Mapping[str, float]]:
        """What a network that scores views is told beside rewards: a loss, and figures."""
        if self.foresight is None or outputs.foresight is None or TO_GO not in frames:
            return 0.0, {}
        decisions = {name: tensor[there] for name, tensor in frames.items()}
        return self.foresight(decisions, outputs.foresight.float()[there])

    def _diverged(self, frames: Mapping[str, Tensor], outputs: Mapping[str, Tensor], part: Sequences) -> None:
        """Name the first tensor on the way to the loss that is not finite."""
        groups = {"frames": frames, "parameter": self.updates.parameters, "": outputs, "played": part.played}
        for kind, tensors in groups.items():
            require_finite({f"{kind} {name}".strip(): tensor for name, tensor in tensors.items()}, self.done)
        raise DivergedError(f"step {self.done + 1}: the loss is not finite; start a run anew with a smaller learner.lr")

    def validate(self) -> Figures:
        """SR and SPL of the policy, or of its average, on validation episodes."""
        with self.updates.averaged():
            self.policy.eval()
            found = self.validation.played(self.players, self.seed)
        return found | {SCORE: found[self.validation.choose]}

    @cached_property
    def players(self) -> Players:
        """Those who play validation episodes."""
        return Players(self.policy, self.make_env, self.validation.slots, self.validation.max_steps)

    def state_dict(self) -> State:
        """Network, its average, moments of the optimiser, counters."""
        return State(self.updates.tensors(), {"done": self.done, "frames": self.frames})

    def load_state_dict(self, state: State) -> None:
        """Go on after ``done`` steps."""
        self.done, self.frames = state.count("done"), state.count("frames")
        self.updates.load(state.tensors, self.done)

    def lengthen(self, steps: int) -> bool:
        """See :class:`ucon.learning.run.protocol.Learner`."""
        return self.updates.lengthen(steps)

    def product(self) -> Mapping[str, bytes]:
        """The network, as the agent that plays it loads it."""
        with self.updates.averaged():
            return network_files(cast(Any, self.network), half=self.options.half)

    def close(self) -> None:
        """See :class:`ucon.learning.run.protocol.Learner`."""
        self.rollouts.close()
        self.players.close()

    def card(self) -> Card:
        """What it is and what for."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        name = self.act.architecture
        learned = (
            f"Learned from {self.frames:,} steps of its own in episodes drawn from {len(self.episodes)} of the `train` "
            f"part; habit levels {', '.join(self.levels)}."
            if self.frames
            else "As it was before training: nothing that was learned validated better."
        )
        return Card(
            f"Policy {name}, by proximal policy optimisation",
            f"`{name}`, {size:,} parameters. {learned} Validation episodes chose the state; `test` was not touched.\n\n"
            f"Use: `python eval.py agent={name} agent.checkpoint=RUN`.\n\n"
            "It learned in simulated homes what a success is worth there; in homes unlike these it was not measured.",
            self.dataset.name,
        )


def _moved(tensors: Mapping[str, Tensor], device: str) -> dict[str, Tensor]:
    return {name: tensor.to(device) for name, tensor in tensors.items()}
