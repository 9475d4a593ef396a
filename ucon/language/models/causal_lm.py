"""``causal_lm``: a text chat model on this machine, scored by :mod:`ucon.language.models.likelihood`.

The system part is the same in all questions of an episode, so its keys and values are kept. The rest of a question is
read once, followed by all its options.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.language.choice import Answer, Question
from ucon.language.models.conversation import common_prefix, most_habits
from ucon.language.models.likelihood import Ids, LikelihoodModel, Ready
from ucon.language.models.orders import MOST, Orders, averaged, in_order
from ucon.language.models.reading import Past, PrefixReader
from ucon.language.models.weights import LocalWeights

#: Two user messages that begin differently: the common prefix of their conversations is the system part.
_USERS: Final = ("A", "?")
#: Habits leave at least one part in this many of the window to the user's message.
_SPARE: Final = 16


@dataclass(frozen=True, eq=False)
class _Ready(Ready):
    shared: Ids
    """The beginning of the prompt, which all questions with this system message share."""
    answers: tuple[Ids, ...]


class CausalModel(LikelihoodModel[_Ready]):
    """Any AutoModelForCausalLM whose tokenizer has a chat template."""

    kind = "causal"
    auto = "AutoModelForCausalLM"

    def __init__(
        self,
        path: str,
        *,
        device: str = "cpu",
        dtype: str = "float32",
        batch_size: int = 8,
        prefixes: int = 4,
        normalise: bool = False,
        window: int | None = None,
        download: bool = False,
        template: Mapping[str, Any] | None = None,
        orders: int = 0,
        seed: int = 0,
    ) -> None:
        """Choose model and options; nothing is read yet.

        Args:
            path: folder in Hugging Face layout, or a name in the Hugging Face cache.
            device: ``cpu``, ``cuda``, ``auto``.
            dtype: ``float32``, ``bfloat16``, ``float16``, ``int8``.
            batch_size: questions in one pass through the network.
            prefixes: system parts whose keys and values are kept; one for each episode played in parallel.
            normalise: mean log-probability of the answer's tokens instead of their sum.
            window: longest prompt and answer in tokens; by default the model's.
            download: fetch a name that is not in the cache from the hub.
            template: options of the chat template, such as ``enable_thinking: false``.
            orders: of options in a question: 0 as the agent lists them, 1 seeded, 2 that and its reverse, averaged.
            seed: of the orders.

        Raises:
            ConfigError: a number out of range, an unknown dtype.
        """
        if prefixes < 0:
            raise ConfigError(f"prefixes={prefixes}: expected at least 0")
        weights = LocalWeights(path, device=device, dtype=dtype, download=download)
        super().__init__(weights, batch_size=batch_size, normalise=normalise, window=window, template=template)
        self._keep, self._orders = prefixes, Orders(orders, seed)
        self._prefixes: OrderedDict[Ids, Past] = OrderedDict()
        self._systems: OrderedDict[str, Ids] = OrderedDict()
        # Number of habits dropped from the last question; most likely the next one needs the same.
        self._dropped = 0

    @property
    def name(self) -> str:
        """Such as ``causal (Llama-3.1-8B-Instruct)``; it says so if each question is asked in two orders."""
        twice = ", two orders" if self._orders.count == MOST else ""
        return f"{self.kind} ({self._weights.short}{twice})"

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions, each in its orders; see :meth:`ucon.language.choice.LanguageModel.answer`."""
        orders = [self._orders.of(question) for question in questions]
        asked = [in_order(one, order) for one, own in zip(questions, orders, strict=True) for order in own]
        answers = iter(super().answer(asked))
        return [averaged(own, list(islice(answers, len(own)))) for own in orders]

    def _ready(self, question: Question) -> _Ready | None:
        answers = tuple(self._ids(option.name) or self._ids("?") for option in question.options)
        # Room is left for longer messages, so that all questions of an episode drop the same habits and share the rest.
        own = len(self._ids(question.situation))
        room = self._window - max(map(len, answers)) - max(self._window // _SPARE - own, 0)
        found = most_habits(
            question.system, lambda system: len(self._prompt(system, question.situation)) <= room, self._dropped
        )
        if found is None:
            return None
        system, self._dropped = found
        prompt = self._prompt(system, question.situation)
        return _Ready(prompt, self._dropped, self._shared(system, prompt), answers)

    def _prompt(self, system: str, situation: str) -> Ids:
        return self._ids(self._template.render(system, situation))

    def _ids(self, text: str) -> Ids:
        """Tokens of a text that already contains the special tokens."""
        clean = text.encode("utf-8", "replace").decode()
        return tuple(self._tokenizer(clean, add_special_tokens=False)["input_ids"])

    def _shared(self, system: str, prompt: Ids) -> Ids:
        """The part of a prompt that is cached; at least the last token is left to be read with the options."""
        if not self._keep:
            return ()
        return prompt[: min(common_prefix(self._system_part(system), prompt), len(prompt) - 1)]

    def _system_part(self, system: str) -> Ids:
        """Tokens with which every conversation with this system message begins."""
        if system not in self._systems:
            a, b = (self._prompt(system, user) for user in _USERS)
            self._systems[system] = a[: common_prefix(a, b)]
            if len(self._systems) > self._keep:
                self._systems.popitem(last=False)
        return self._systems[system]

    def _scores(self, group: Sequence[_Ready]) -> list[NDArray[np.float64]]:
        import torch

        with torch.inference_mode():
            started = self._started([one.shared for one in group])
            said = self._forked(started, group) if self._reader.forking else self._in_turn(started, group)
            return [
                np.array([self._log_prob(x.log_softmax(-1).cpu(), a) for x, a in zip(own, one.answers, strict=True)])
                for own, one in zip(said, group, strict=True)
            ]

    def _forked(self, started: Sequence[Past], group: Sequence[_Ready]) -> list[list[Any]]:
        """Logits after the end of each prompt and the tokens of each answer, in one pass."""
        return self._reader.forked(
            started, [one.prompt[len(one.shared) :] for one in group], [one.answers for one in group]
        )

    def _in_turn(self, started: Sequence[Past], group: Sequence[_Ready]) -> list[list[Any]]:
        """The same for models that cannot fork a row: first the prompt, then one row per answer."""
        out: list[list[Any]] = [[] for _ in group]
        # All but the last token of each prompt: the last one predicts the answer's first token, so it is read again
        # with each answer.
        pasts = self._reader.after(started, [one.prompt[len(one.shared) : -1] for one in group])
        for part in self._parts([one.answers for one in group]):
            rows = [group[k].prompt[-1:] + answer for k, answer in part]
            for said, (k, _) in zip(self._reader.logits([pasts[k] for k, _ in part], rows), part, strict=True):
                out[k].append(said)  # (T + 1, V)
        return out

    def _started(self, shared: Sequence[Ids]) -> list[Past]:
        """The pasts after system parts; those that are not cached are computed in one batch."""
        new = [ids for ids in dict.fromkeys(shared) if ids not in self._prefixes]
        nothing = self._reader.nothing()
        found = {**self._prefixes, **dict(zip(new, self._reader.after([nothing] * len(new), new), strict=True))}
        for ids in filter(None, shared):
            self._prefixes[ids] = found[ids]
            self._prefixes.move_to_end(ids)
        while len(self._prefixes) > self._keep:
            self._prefixes.popitem(last=False)
        return [found[ids] for ids in shared]

    @property
    def _together(self) -> bool:
        return self._reader.together

    @cached_property
    def _reader(self) -> PrefixReader:
        return PrefixReader(self._model, self._ends[0])

    @property
    def _owner(self) -> Any:
        return self._tokenizer

    @cached_property
    def _tokenizer(self) -> Any:
        import transformers

        return self._weights.read(transformers.AutoTokenizer.from_pretrained)
