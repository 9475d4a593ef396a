"""``habit_policy``: belief, map and walking are computed by fixed rules; the choice of the next view is learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from models.agents.base import slots_of
from models.agents.checkpoint import NetworkCheckpoint
from models.agents.judging import judge_of
from models.agents.search import SearchLog
from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.core.rng import stream
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.learning.policies.action_policy import rounded_logits
from ucon.perception.belief.from_habits import Locate, ReadHabits, expecting
from ucon.perception.drawing.map_picture import Image
from ucon.perception.views.viewpoints import Choice
from ucon.search.search_decision import SearchDecision
from ucon.search.search_tokens import Sizes, TokenReader, Tokens
from ucon.search.searcher import MISS, Searcher
from ucon.search.text_tokens import EpisodeTextTokens, TextTokens, name_table
from ucon.search.thoughts import Thoughts, thoughts_of
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation

if TYPE_CHECKING:
    from torch import Tensor

    from models.habit_policy import HabitPolicy


@dataclass
class _Search:
    """State of one slot's episode."""

    episode: str
    searcher: Searcher
    reader: TokenReader
    said: EpisodeTextTokens
    log: SearchLog
    chosen: tuple[Tokens, int] | None = None
    """Tokens of the network's last choice, and the row that it chose."""
    decided: SearchDecision | None = None
    """The views of its last step; None where no choice was due."""

    def go(self, choice: Choice | None, also: str = "") -> Action:
        """Set out for ``choice``, record why, and return the first action."""
        self.decided = self.searcher.decision()
        self.log.chose(self.searcher, self.decided, choice, also)
        return self.searcher.choose(choice)


class HabitPolicyAgent:
    """Lets the habit policy choose among views, for many slots in one forward pass."""

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
        judge: str | None = "shipped",
        sample: bool = False,
        seed: int = 0,
        device: str = "cpu",
    ) -> None:
        """Set up the agent; weights are loaded when they are first needed.

        Args:
            policy: the network.
            checkpoint: folder of weights or run of ``train.py``; ``shipped``; ``untrained`` plays the initial weights;
                None: there are no weights yet.
            locate: gives the distribution over the target's places; by default it is read from the habits.
            miss: probability that a look at a place misses a target there; at 1, empty places do not change the belief.
            sizes: numbers of token rows, as in training.
            judge: of suspects, where the detector errs: ``shipped``, a folder, or None for the arithmetic posterior.
            text: embeds names and habits, as in training.
            sample: draw views from the policy's probabilities; each draw is a function of seed, episode and decision.
            seed: of the draws.
            device: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.

        Raises:
            ConfigError: ``miss`` out of range.
        """
        self.policy = policy
        self._weights = NetworkCheckpoint(policy, checkpoint)
        self.locate, self._sizes, self._text = locate or ReadHabits(), sizes or Sizes(), text or TextTokens()
        if type(miss) not in (int, float) or not 0.0 < miss <= 1.0:
            raise ConfigError(f"agent.miss={brief(miss)}: expected a chance above 0, at most 1")
        self._miss = miss
        self.judge = judge_of(judge)
        self._sample, self._seed, self._device = sample, seed, device
        self._ready, self._adds = False, True
        self._searches: dict[int, _Search] = {}

    @property
    def name(self) -> str:
        """Name for tables: the architecture, with "(untrained)" where that applies."""
        return self._weights.name

    def check(self) -> None:
        """Raise a one-line error where weights or the device are missing, or weights do not fit.

        Raises:
            ConfigError: no such device, or no checkpoint was named.
            DataError: no weights there, damaged ones, or those of another network.
        """
        torch_device(self._device, "agent.device")
        self._weights.load()

    def fingerprint(self) -> str | None:
        """Hash of the network's and the reader's weights; None where the network's are missing.

        See :mod:`ucon.evaluation.playing.needed_weights`.
        """
        reader, own = str(fingerprint_of(self.locate)), self._weights.sha256()
        if own is None:
            return None
        return sha256_bytes(f"{own} {reader}".encode()) if own else reader

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start episodes in some slots: read the habits, begin an empty map.

        Args:
            infos: of the environments' resets.
            slots: their numbers; None: the first ones.
        """
        self._prepare()
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            believing = expecting(info, self.locate)
            searcher = Searcher(info, believing, miss=self._miss, judge=self.judge)
            reader = TokenReader(searcher, info, self._sizes)
            said = EpisodeTextTokens(self._text, str(info["target"]), believing)
            self._searches[slot] = _Search(str(info.get("episode", "")), searcher, reader, said, SearchLog(info))

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """The next action in some slots; where views are to be chosen, the network scores all slots at once.

        Args:
            observations: one for each slot.
            infos: one for each slot.
            slots: their numbers; None: the first ones.

        Returns:
            Actions from 0 to 6, in the order of the slots.

        Raises:
            DataError: the network's scores are NaN.
        """
        numbers = list(slots_of(infos, slots))
        actions: dict[int, Action | None] = {}
        due: dict[int, Tokens] = {}
        for slot, observation, info in zip(numbers, observations, infos, strict=True):
            search = self._searches[slot]
            actions[slot] = search.searcher.look(observation, info)
            search.decided = None
            search.log.looked(search.searcher, actions[slot])
            if actions[slot] is None:
                read = search.reader.read if self._adds else search.reader.read_views
                tokens = read(search.searcher.decision())
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
        """Decisions in a slot since its reset."""
        return self._searches[slot].log.decisions

    def thoughts(self, slot: int) -> Thoughts:
        """Belief, goal and other views in a slot after its last action, as plain values."""
        search = self._searches[slot]
        return thoughts_of(search.searcher, search.decided)

    def picture(self, slot: int) -> Image:
        """Picture of the map and belief in a slot, (384, W, 3) uint8; see :func:`ucon.search.picture.draw_search`.

        Belief over cost drives the search, so the habits shown are those that the belief head relied on. If the
        transformer adds anything to that (the shipped one does not), a last line gives the attention of the chosen
        view.
        """
        from ucon.search.picture import draw_search

        return draw_search(self._searches[slot].searcher, also=self._attending(slot))

    def _attending(self, slot: int) -> str:
        """Attention of the last chosen view by kind of token, in words; "" where there is nothing to say."""
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
        """Row of the chosen view in each slot of ``due``."""
        import torch

        if not due:
            return []
        with torch.inference_mode():
            if self._adds:
                scores = self.policy(self._tensors(due)).logits
            else:
                arrays = [tokens.arrays for tokens in due.values()]
                known = {name: np.stack([row[name] for row in arrays]) for name in ("prior", "views", "action_mask")}
                scores = self.policy.by_gain_over_cost(
                    {name: torch.from_numpy(array).float().to(self._device) for name, array in known.items()}
                )
        logits = rounded_logits(scores)
        return [self._choose(row, self._searches[slot]) for slot, row in zip(due, logits, strict=True)]

    def _tensors(self, due: dict[int, Tokens]) -> dict[str, Tensor]:
        """Network inputs of the decisions in some slots, (B, ...) float32 by name."""
        import torch

        rows = [{**tokens.arrays, **self._searches[slot].said()} for slot, tokens in due.items()]
        batch = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
        names = self._names[batch.pop("thing_rows")]
        tensors = {name: torch.from_numpy(array).float().to(self._device) for name, array in batch.items()}
        return tensors | {"thing_names": torch.from_numpy(names).to(self._device)}

    def _choose(self, logits: np.ndarray[Any, np.dtype[np.float64]], search: _Search) -> int:
        """Row of the highest logit (V,), or a sampled one."""
        if np.isnan(logits).any():
            step = search.searcher.map.step
            raise DataError(f"agent {self.name}: scores are NaN at step {step}; train it again")
        if not self._sample:
            return int(logits.argmax())
        weights = np.exp(logits - logits.max())
        draw = stream(self._seed, self.policy.architecture, search.episode, search.searcher.decisions)
        return int(draw.choice(len(weights), p=weights / weights.sum()))

    @cached_property
    def _names(self) -> np.ndarray[Any, np.dtype[np.float32]]:
        """Embeddings of category names, (n + 1, 384) float32; the last row stands for no category."""
        return name_table(self._text.encoder)

    def _prepare(self) -> None:
        if not self._ready:
            self._weights.load()
            self._device = torch_device(self._device, "agent.device")
            self.policy.to(self._device).eval()
            self._adds, self._ready = self.policy.adds, True
