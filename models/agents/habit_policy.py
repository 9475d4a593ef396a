"""``habit_policy``: belief, map and walking are arithmetic; where to look next is learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from models.agents.base import slots_of
from models.agents.checkpoint import NetworkCheckpoint
from models.agents.search import SearchLog
from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.core.rng import stream
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.learning.policies.action_policy import comparable
from ucon.perception.belief.from_habits import Locate, ReadHabits, expecting
from ucon.perception.drawing.map_picture import Image
from ucon.perception.views.viewpoints import Choice
from ucon.search.search_tokens import Sizes, TokenReader, Tokens
from ucon.search.searcher import MISS, Searcher
from ucon.search.text_tokens import EpisodeTextTokens, TextTokens, name_table
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation

if TYPE_CHECKING:
    from torch import Tensor

    from models.habit_policy import HabitPolicy


@dataclass
class _Search:
    """One slot's episode."""

    episode: str
    searcher: Searcher
    reader: TokenReader
    said: EpisodeTextTokens
    log: SearchLog
    chosen: tuple[Tokens, int] | None = None
    """What the network last chose among, and the row that it chose."""

    def go(self, choice: Choice | None, also: str = "") -> Action:
        """Go where ``choice`` says, and write down why."""
        self.log.chose(self.searcher, self.searcher.decision(), choice, also)
        return self.searcher.choose(choice)


class HabitPolicyAgent:
    """Scores views by the habit policy, for many slots in one forward."""

    uses_habits = True

    def __init__(
        self,
        policy: HabitPolicy,
        checkpoint: str | None = None,
        *,
        locate: Locate | None = None,
        miss: float = MISS,
        sizes: Sizes | None = None,
        text: TextTokens | None = None,
        sample: bool = False,
        seed: int = 0,
        device: str = "cpu",
    ) -> None:
        """Describe the agent; weights are read when they are needed.

        Args:
            policy: the network.
            checkpoint: folder of its weights, or a run of ``train.py``; ``shipped``; ``untrained`` plays the policy as
                it is; None: they are still to be trained.
            locate: says where the target may be; by default it is read from the habits.
            miss: chance that a look at a place misses the target there; at 1 what was found empty teaches nothing.
            sizes: rows of the tokens, as in training.
            text: embeds names and habits, as in training.
            sample: draw views by the policy's probabilities; each draw is a function of seed, episode and decision.
            seed: of the draws.
            device: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.
        """
        self.policy = policy
        self._weights = NetworkCheckpoint(policy, checkpoint)
        self._locate, self._sizes, self._text = locate or ReadHabits(), sizes or Sizes(), text or TextTokens()
        if type(miss) not in (int, float) or not 0.0 < miss <= 1.0:
            raise ConfigError(f"agent.miss={brief(miss)}: expected a chance above 0, at most 1")
        self._miss = miss
        self._sample, self._seed, self._device = sample, seed, device
        self._ready = False
        self._searches: dict[int, _Search] = {}

    @property
    def name(self) -> str:
        """The architecture, and whether nobody trained it."""
        return self._weights.name

    def check(self) -> None:
        """Fail in one line where weights or the device are missing, or weights do not fit.

        Raises:
            ConfigError: no such device, or no weights were named.
            DataError: no weights there, damaged ones, or those of another network.
        """
        torch_device(self._device, "agent.device")
        self._weights.load()

    def fingerprint(self) -> str | None:
        """Which weights these are, see :mod:`ucon.evaluation.playing.needed_weights`."""
        reader, own = str(fingerprint_of(self._locate)), self._weights.sha256()
        if own is None:
            return None
        return sha256_bytes(f"{own} {reader}".encode()) if own else reader

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """See :class:`ucon.task.agent.Agent`."""
        self._prepare()
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            believing = expecting(info, self._locate)
            searcher = Searcher(info, believing, miss=self._miss)
            reader = TokenReader(searcher, info, self._sizes)
            said = EpisodeTextTokens(self._text, str(info["target"]), believing)
            self._searches[slot] = _Search(str(info.get("episode", "")), searcher, reader, said, SearchLog(info))

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """See :class:`ucon.task.agent.Agent`."""
        numbers = list(slots_of(infos, slots))
        actions: dict[int, Action | None] = {}
        due: dict[int, Tokens] = {}
        for slot, observation, info in zip(numbers, observations, infos, strict=True):
            search = self._searches[slot]
            actions[slot] = search.searcher.look(observation, info)
            search.log.looked(search.searcher, actions[slot])
            if actions[slot] is None:
                tokens = search.reader.read(search.searcher.decision())
                if len(tokens.choices) > 1:
                    due[slot] = tokens
                else:
                    actions[slot] = search.go(next(iter(tokens.choices), None))
        for slot, row in zip(due, self._chosen(due), strict=True):
            self._searches[slot].chosen = due[slot], row
            choices = due[slot].choices
            actions[slot] = self._searches[slot].go(choices[row], f", of {len(choices)} views")
        return [int(actions[slot]) for slot in numbers]  # type: ignore[arg-type]

    def decisions(self, slot: int) -> list[DecisionRecord]:
        """What was chosen in a slot since its reset."""
        return self._searches[slot].log.decisions

    def picture(self, slot: int) -> Image:
        """What it thinks; see :func:`ucon.search.picture.draw_search`.

        Belief over cost is what drives the search: the habits shown are those that the belief head was moved by. Of a
        transformer that adds something to that, which the shipped one does not, a last line says what the chosen view
        attends to.
        """
        from ucon.search.picture import draw_search

        return draw_search(self._searches[slot].searcher, also=self._attending(slot))

    def _attending(self, slot: int) -> str:
        """Shares of the attention of the view that was chosen last, by kind of token; "" where none is told."""
        import torch

        search = self._searches[slot]
        if search.chosen is None or search.searcher.taking or not self.policy.adds:
            return ""
        tokens, row = search.chosen
        with torch.inference_mode():
            attended = self.policy.attention(self._tensors({slot: tokens}))
        shares = {kind: float(part[0, row].sum()) for kind, part in attended._asdict().items()}
        return "attends to: " + ", ".join(f"{kind} {share:.0%}" for kind, share in shares.items() if kind != "ego")

    def _chosen(self, due: dict[int, Tokens]) -> list[int]:
        """Rows of the views that are chosen in the slots where a choice is due."""
        import torch

        if not due:
            return []
        with torch.inference_mode():
            scores = self.policy(self._tensors(due))
        logits = comparable(scores.logits)
        return [self._choose(row, self._searches[slot]) for slot, row in zip(due, logits, strict=True)]

    def _tensors(self, due: dict[int, Tokens]) -> dict[str, Tensor]:
        """What the network reads of the decisions in some slots."""
        import torch

        rows = [{**tokens.arrays, **self._searches[slot].said()} for slot, tokens in due.items()]
        batch = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
        names = self._names[batch.pop("thing_rows")]
        tensors = {name: torch.from_numpy(array).float().to(self._device) for name, array in batch.items()}
        return tensors | {"thing_names": torch.from_numpy(names).to(self._device)}

    def _choose(self, logits: np.ndarray[Any, np.dtype[np.float64]], search: _Search) -> int:
        if np.isnan(logits).any():
            step = search.searcher.map.step
            raise DataError(f"agent {self.name}: scores that are no numbers at step {step}; train it anew")
        if not self._sample:
            return int(logits.argmax())
        heat = np.exp(logits - logits.max())
        draw = stream(self._seed, self.policy.architecture, search.episode, search.searcher.decisions)
        return int(draw.choice(len(heat), p=heat / heat.sum()))

    @cached_property
    def _names(self) -> np.ndarray[Any, np.dtype[np.float32]]:
        return name_table(self._text.encoder)

    def _prepare(self) -> None:
        if not self._ready:
            self._weights.load()
            self._device = torch_device(self._device, "agent.device")
            self.policy.to(self._device).eval()
            self._ready = True
