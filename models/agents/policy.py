"""Any policy over the seven actions as an agent: many environments in one forward pass, a recurrent state for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from models.agents.base import slots_of
from models.agents.checkpoint import NetworkCheckpoint
from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import sha256_bytes
from ucon.core.rng import stream
from ucon.learning.policies.action_policy import Arrays, Tensors, rounded_logits, stacked, tensors_of
from ucon.search.thoughts import Thoughts
from ucon.task.agent import Info, Observation
from ucon.task.rules import PAPER, task_rules

if TYPE_CHECKING:
    from models.nets.policy_defaults import PolicyModule


@dataclass
class _Episode:
    """State of one slot's episode."""

    info: Info
    """``info`` of its reset."""
    context: Tensors
    """Context tensors (...), without a batch axis."""
    state: Tensors
    """Recurrent state, tensors (...), without a batch axis."""
    steps: int = 0
    last: tuple[Tensors, Tensors] | None = None
    """The last frame and the recurrent state before it, from which a picture is computed."""


class PolicyAgent:
    """Plays a policy: takes the action of the highest logit, or samples.

    With ``batch=1``, records are byte-identical for any number of workers. In a larger batch sums may differ in their
    last bits, which can change an action where two logits are almost equal.
    """

    def __init__(
        self,
        policy: PolicyModule,
        checkpoint: str | None = None,
        *,
        sample: bool = False,
        temperature: float = 0.6,
        seed: int = 0,
        device: str = "cpu",
    ) -> None:
        """Set up the agent; weights are loaded when they are first needed.

        Args:
            policy: the network.
            checkpoint: folder of weights or run of ``train.py``; ``shipped``; ``untrained`` plays the initial weights;
                None: there are no weights yet.
            sample: draw actions from the policy's probabilities instead of taking the best; each draw is a function of
                seed, episode and step.
            temperature: logits are divided by it before a draw; below 1, likely actions become likelier.
            seed: of the draws.
            device: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.

        Raises:
            ConfigError: a temperature out of range.
        """
        if type(temperature) not in (int, float) or not 0.01 <= temperature <= 100:
            raise ConfigError(f"agent.temperature={brief(temperature)}: expected a number from 0.01 to 100")
        self.policy = policy
        self._weights = NetworkCheckpoint(policy, checkpoint)
        self._sample, self._temperature, self._seed, self._device = sample, float(temperature), seed, device
        self._ready = False
        self._episodes: dict[int, _Episode] = {}

    @property
    def name(self) -> str:
        """Name for tables: the architecture, with "(untrained)" where that applies."""
        return self._weights.name

    @property
    def uses_habits(self) -> bool:
        """Whether the policy's outputs depend on the habits."""
        return self.policy.uses_habits

    def check(self) -> None:
        """Raise a one-line error where weights or the device are missing, or weights do not fit.

        Raises:
            ConfigError: no such device, or no checkpoint was named.
            DataError: no weights, damaged ones, or those of another network.
        """
        torch_device(self._device, "agent.device")
        self.policy.check()
        self._weights.load()

    def fingerprint(self) -> str | None:
        """Hash of the trained and frozen weights; None where some are missing.

        See :mod:`ucon.evaluation.playing.needed_weights`.
        """
        frozen, own = self.policy.fingerprint(), self._weights.sha256()
        if frozen is None or own is None:
            return None
        return sha256_bytes(f"{own} {frozen}".encode()) if own else frozen

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start episodes in some slots, with fresh recurrent states.

        Args:
            infos: of the environments' resets.
            slots: their numbers; None: the first ones.

        Raises:
            ConfigError: more habits than the weights were trained with, or a task whose turns are not 90 degrees.
        """
        for info in infos:
            _check_turns(self.name, info)
        self._prepare()
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            self._check_length(info)
            state = {name: tensor[0] for name, tensor in self.policy.initial_state(1).items()}
            context = self._tensors(self.policy.context(info))
            self._episodes[slot] = _Episode(info, context, state)

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """The next action in some slots, in one forward pass.

        Args:
            observations: one for each slot.
            infos: one for each slot.
            slots: their numbers; None: the first ones.

        Returns:
            Actions from 0 to 6, in the order of the slots.

        Raises:
            DataError: logits that are not finite.
        """
        import torch

        episodes = [self._episodes[slot] for slot in slots_of(infos, slots)]
        frames = [self._tensors(self.policy.frame(o, i)) for o, i in zip(observations, infos, strict=True)]
        with torch.inference_mode():
            steps = {name: tensor[None] for name, tensor in stacked(frames).items()}  # (1, B, ...)
            context, state = stacked([e.context for e in episodes]), stacked([e.state for e in episodes])
            outputs = self.policy(steps, context, state)
            logits = rounded_logits(outputs.logits[0])  # (B, 7)
        actions = []
        for row, (episode, values) in enumerate(zip(episodes, logits, strict=True)):
            actions.append(self._choose(values, episode))
            episode.last = frames[row], episode.state
            episode.state = {name: tensor[row] for name, tensor in outputs.state.items()}
            episode.steps += 1
        return actions

    def thoughts(self, slot: int) -> Thoughts | None:
        """For reports: what the policy thinks after its last step in a slot; None where it keeps no belief."""
        return self._of_last_step(slot, "thoughts") if hasattr(self.policy, "thoughts") else None

    def picture(self, slot: int) -> NDArray[np.uint8] | None:
        """For videos: a picture of the policy's last step in a slot.

        Returns:
            (384, W, 3) uint8, or None where the policy draws nothing.
        """
        return self._of_last_step(slot, "picture")

    def _of_last_step(self, slot: int, name: str) -> Any:
        """Result of the policy's ``picture`` or ``thoughts`` for the last step in a slot; None before the first."""
        import torch

        episode = self._episodes[slot]
        if episode.last is None:
            return None
        frame, state = episode.last
        frames = {name: tensor[None, None] for name, tensor in frame.items()}
        with torch.inference_mode():
            return getattr(self.policy, name)(episode.info, frames, stacked([episode.context]), stacked([state]))

    def _choose(self, logits: NDArray[np.float64], episode: _Episode) -> int:
        if not np.isfinite(logits).all():
            raise DataError(f"agent {self.name}: logits are not finite at step {episode.steps}; train it again")
        if not self._sample:
            return int(logits.argmax())
        weights = np.exp((logits - logits.max()) / self._temperature)
        draw = stream(self._seed, self.policy.architecture, str(episode.info.get("episode", "")), episode.steps)
        return int(draw.choice(len(weights), p=weights / weights.sum()))

    def _check_length(self, info: Info) -> None:
        n, most = len(info.get("habits", ())), self.policy.max_habits
        if most is not None and n > most and not self._weights.untrained:
            raise ConfigError(
                f"episode {info.get('episode', '')}: {n} habits, but {self.name} was trained with at most {most}; give "
                f"habit_level=retrieval or fewer habits, or train it with env.max_habits={n}"
            )

    def _tensors(self, arrays: Arrays) -> Tensors:
        return tensors_of(arrays, self.policy.device)

    def _prepare(self) -> None:
        if self._ready:
            return
        self._weights.load()
        self.policy.to(torch_device(self._device, "agent.device")).eval()
        self._ready = True


def _check_turns(name: str, info: Info) -> None:
    """Refuse a task whose turns differ from those that a policy over the seven actions was trained with."""
    rules = task_rules(str(info.get("task", PAPER.name)))
    if rules.turn_deg != PAPER.turn_deg:
        raise ConfigError(
            f"agent {name}: trained with turns of {PAPER.turn_deg} degrees, but task={rules.name} turns by "
            f"{rules.turn_deg}; choose an agent that builds a map, such as agent=belief or agent=habit_policy"
        )
