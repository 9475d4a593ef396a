"""``learner=ppo``: a policy is trained on its own play (PPO), with TorchRL's collectors, advantages and loss.

One step is one collection and a few passes over it. The policy is one over the seven actions, or a network that scores
views, such as the habit policy. Each collection begins with fresh episodes, drawn by the seed and the number of the
step, so the state between steps is only that of the network and its optimiser.
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
from ucon.learning.policies.action_policy import ActionPolicy, scores_views
from ucon.learning.policies.playing import Players
from ucon.learning.policies.validation import Validation, evenly_spaced
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.ppo.checks import check_choices, check_taught, collection_size
from ucon.learning.ppo.clipped_loss import PPOLoss, eval_mode_except_rnn, finite, mean_figures
from ucon.learning.ppo.collecting import Collecting, ExperienceCollector
from ucon.learning.ppo.experience import Experience, Sequences
from ucon.learning.ppo.own_play_card import own_play_card
from ucon.learning.run.network_files import load_network, network_files, set_max_habits
from ucon.learning.run.option_checks import check_parts, text_weights
from ucon.learning.run.options import PPOOptions
from ucon.learning.run.protocol import Card, Figures, State
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.updates import Updates, require_finite
from ucon.task.sets import load_episodes


class PPOLearner:
    """Proximal policy optimisation of a policy over actions or of a network over views (see the module).

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module, or a network that
            scores views; training starts from its present weights.
        env: makes an environment of ``UcON-v0``; pickled and sent to workers.
        search: makes an environment of ``UcONSearch-v0``, for networks that score views.
        collector: plays in this process or in workers.
        loss: PPO's loss of a minibatch.
        validation: validation episodes; ``success_rate`` or ``spl`` chooses the best checkpoint.
        options: fields of :class:`ucon.learning.run.options.PPOOptions`.

    Raises:
        ConfigError: a value of the wrong type or out of range, or episodes outside the ``train`` part.
        DataError: ``initial`` holds no weights, or those of another network.
    """

    options_of = PPOOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(
        self,
        policy: nn.Module,
        env: Callable[[], Any],
        search: Callable[[], Any],
        collector: Collecting,
        loss: PPOLoss,
        validation: Validation,
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
        self.chunk = given.chunk if self.act.initial_state(1) else 1
        each = -(-collection_size(self.act, given.frames) // collector.rows) + 1  # the last step is not trained on
        self.rollouts = ExperienceCollector(self.policy, self.make_env, self.episodes, self.levels, collector, each)
        self.policy.to(self.device)
        self.updates = Updates(
            self.policy, lr=given.lr, clip=given.clip, steps=given.steps if given.anneal else 0,
            warm_up=given.warm_up, decay=given.decay, average=given.average,
        )  # fmt: skip
        self.done, self.frames = 0, 0

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of everything that training starts from; a checkpoint with other hashes is refused.

        Keys: ``habits``, ``episodes``, and where they apply ``frozen`` (weights of frozen networks), ``reader``
        (weights that read habits in ``UcONSearch-v0``), ``initial`` and ``text`` (weights that embed and rank habits).
        """
        of_episodes = [f"{e.id} {e.home_hash} {e.solution}" for e in (*self.episodes, *self.validation.all)]
        frozen = fingerprint_of(self.policy)
        text = text_weights(self.source, (*self.levels, self.validation.level))
        hashes = {"habits": self.dataset.sha256, "episodes": sha256_bytes("\n".join(of_episodes).encode())}
        others = {"frozen": frozen, "reader": self._read_by, "initial": self._initial, "text": text}
        return hashes | {name: by for name, by in others.items() if by}

    @property
    def resolved_options(self) -> Mapping[str, str]:
        """Values chosen for options given as ``auto``, by option: ``device`` and ``precision``.

        The run stores them, so that it continues with the same values on another machine.
        """
        return {"device": self.device, "precision": str(self._precision).removeprefix("torch.")}

    def step(self) -> Figures:
        """Collect once, and update the policy in up to ``epochs`` passes.

        Returns:
            Means over minibatches of the losses and ``kl``, figures of the collection, ``passes``, and ``frames`` so
            far.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        with part("collecting"):
            batch = self.rollouts.collect(derived_seed(self.seed, "collect", self.done))
        experience = Experience(batch, self.options.discount, self.options.trace, self.chunk)
        eval_mode_except_rnn(self.policy)
        learned: list[Mapping[str, float]] = []
        passes = 0
        for epoch in ticked("updating", range(self.options.epochs)):
            draw = stream(self.seed, "minibatches", self.done, epoch)
            first = len(learned)
            learned += [self._update(some) for some in experience.minibatches(self.options.minibatch, draw)]
            passes += 1
            if mean_figures(learned[first:])["kl"] > self.options.kl_stop:
                break
        for frames in experience.frame_batches(self.options.minibatch):
            self.act.update_statistics(_moved(frames, self.device))
        self.done += 1
        self.frames += len(experience)
        figures = experience.figures() | mean_figures(learned)
        return figures | {"passes": float(passes), "frames": float(self.frames)}

    def _update(self, part: Sequences) -> Mapping[str, float]:
        """Update the policy on one minibatch; figures to log."""
        device = self.device
        frames, context, state = (_moved(tensors, device) for tensors in (part.frames, part.context, part.state))
        kind = torch.device(device).type
        with torch.autocast(kind, self._precision, enabled=self._precision != torch.float32):
            outputs = self.act(frames, context, state)
        there = part.there.to(device)
        logits, value = outputs.logits.float()[there], outputs.value.float()[there]
        checked = {"logits": logits.masked_fill(logits == -torch.inf, 0.0), "value": value}
        if not all(map(finite, checked.values())):  # TorchRL's loss would raise an error of its own
            self._diverged(frames, checked, part)
        loss, figures = self.loss(part.played, logits, value)
        if not finite(loss):
            self._diverged(frames, checked, part)
        self.updates.begin()
        loss.backward()  # type: ignore[no-untyped-call]
        return {"loss": float(loss.detach()), **figures, **self.updates.take(self.done)}

    def _diverged(self, frames: Mapping[str, Tensor], outputs: Mapping[str, Tensor], part: Sequences) -> None:
        """Raise an error that names the first tensor, from inputs to loss, that is not finite."""
        groups = {"frames": frames, "parameter": self.updates.parameters, "": outputs, "played": part.played}
        for kind, tensors in groups.items():
            require_finite({f"{kind} {name}".strip(): tensor for name, tensor in tensors.items()}, self.done)
        raise DivergedError(f"step {self.done + 1}: the loss is not finite; start a new run with a smaller learner.lr")

    def validate(self) -> Figures:
        """SR and SPL of the averaged policy on validation episodes, mean ``steps``, and ``score``."""
        with self.updates.averaged():
            self.policy.eval()
            found = self.validation.played(self.players, self.seed)
        return found | {SCORE: found[self.validation.choose]}

    @cached_property
    def players(self) -> Players:
        """Environments in which the policy plays validation episodes; made on first use."""
        return Players(self.policy, self.make_env, self.validation.slots, self.validation.max_steps)

    def state_dict(self) -> State:
        """Weights, their moving average, optimiser moments, and the counters ``done`` and ``frames``."""
        return State(self.updates.tensors(), {"done": self.done, "frames": self.frames})

    def load_state_dict(self, state: State) -> None:
        """Restore a state of :meth:`state_dict`; the next step is number ``done``.

        Raises:
            DataError: a state of another network or learner.
        """
        self.done, self.frames = state.count("done"), state.count("frames")
        self.updates.load(state.tensors, self.done)

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all, from the next step on.

        False where the rate is constant.
        """
        return self.updates.lengthen(steps)

    def product(self) -> Mapping[str, bytes]:
        """Files of the averaged network, by name, as the agent that plays it loads them.

        Raises:
            DataError: a weight that is not finite, or too large for float16.
        """
        with self.updates.averaged():
            return network_files(cast(Any, self.network), half=self.options.half)

    def close(self) -> None:
        """End the workers and close the environments of validation."""
        self.rollouts.close()
        self.players.close()

    def card(self) -> Card:
        """Text of the model card: architecture, size, training episodes, levels and how to use the weights."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        name = self.act.architecture
        return own_play_card(
            f"Policy {name}, by proximal policy optimisation", name, size,
            frames=self.frames, episodes=len(self.episodes), levels=self.levels, dataset=self.dataset.name,
        )  # fmt: skip


def _moved(tensors: Mapping[str, Tensor], device: str) -> dict[str, Tensor]:
    """The tensors on a device, by name."""
    return {name: tensor.to(device) for name, tensor in tensors.items()}
