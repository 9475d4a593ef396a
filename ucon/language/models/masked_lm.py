"""``masked_lm``: a masked language model (RoBERTa) fills the gap of a sentence, by pseudo-log-likelihood.

The text is as many whole habits as fit, followed by the question's cloze with an option's name. Only the name's own
tokens are masked, one at a time, with all others visible. An option's score is the mean log-probability of these
(Salazar et al., 2020). The mean is taken since names differ in length; the rest of the sentence is the same for all.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np

from ucon.core.errors import ConfigError, DataError
from ucon.language.choice import Answer, Question, from_scores
from ucon.language.models.local import LocalModel
from ucon.language.models.weights import LocalWeights
from ucon.language.prompt import neutral

#: RoBERTa counts positions from 2, so its 514 hold 512 tokens.
_UNUSED_POSITIONS: Final = 2
_REMEMBERED: Final = 20_000


class MaskedModel(LocalModel):
    """Any AutoModelForMaskedLM with a fast tokenizer."""

    kind = "masked"

    def __init__(
        self,
        path: str = "FacebookAI/roberta-large",
        *,
        budget_tokens: int = 400,
        batch_size: int = 16,
        device: str = "cpu",
        dtype: str = "float32",
        download: bool = False,
    ) -> None:
        """Choose model and options; nothing is read yet.

        Args:
            path: folder in Hugging Face layout, or a name in the Hugging Face cache.
            budget_tokens: most tokens of all habits together.
            batch_size: masked copies in one pass through the network.
            device: ``cpu``, ``cuda``, ``auto``.
            dtype: of the weights.
            download: fetch a name that is not in the cache from the hub.

        Raises:
            ConfigError: a number out of range, an unknown dtype.
        """
        if batch_size < 1 or budget_tokens < 0:
            raise ConfigError(f"batch_size={batch_size}, budget_tokens={budget_tokens}: expected at least 1 and 0")
        super().__init__(LocalWeights(path, device=device, dtype=dtype, download=download))
        self._budget, self._batch = budget_tokens, batch_size
        self._known: OrderedDict[tuple[str, int, int], float] = OrderedDict()
        self._lengths: dict[str, int] = {}

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions one at a time; see :meth:`ucon.language.choice.LanguageModel.answer`."""
        return [self._answer(question) for question in questions]

    def _answer(self, question: Question) -> Answer:
        start = time.perf_counter()
        cloze = question.cloze or made_cloze(question)
        names = [" ".join(neutral(option.name).split()) or "?" for option in question.options]
        room = self._window - max(len(self._ids(cloze.replace("{}", name))) for name in names)
        if room < 0:
            return Answer(-1, failure="too long", seconds=time.perf_counter() - start)
        kept = self._fitting(question.habits, min(self._budget, room))
        scores = [self._score(" ".join([*kept, cloze]), name) for name in names]
        tokens = sum(self._length(habit) for habit in kept) + self._window - room
        return from_scores(
            np.asarray(scores),
            prompt_tokens=tokens,
            seconds=time.perf_counter() - start,
            dropped=len(question.habits) - len(kept),
        )

    def _fitting(self, habits: Sequence[str], room: int) -> list[str]:
        """Whole habits from the start of the list, as many as fit into ``room`` tokens."""
        kept: list[str] = []
        for habit in map(neutral, habits):
            room -= self._length(habit)
            if room < 0:
                break
            kept.append(habit)
        return kept

    def _length(self, habit: str) -> int:
        """Tokens of a habit and the space after it."""
        if habit not in self._lengths:
            self._lengths[habit] = len(self._tokenizer(f" {habit} ", add_special_tokens=False)["input_ids"])
        return self._lengths[habit]

    def _score(self, text: str, name: str) -> float:
        """Mean log-probability of the name's tokens in the gap; cached, since agents see the same things again."""
        place = text.rindex("{}")
        whole = text[:place] + name + text[place + 2 :]
        key = (whole, place, len(name))
        if key not in self._known:
            self._known[key] = self._computed(whole, place, place + len(name))
            if len(self._known) > _REMEMBERED:
                self._known.popitem(last=False)
        return self._known[key]

    def _computed(self, text: str, start: int, end: int) -> float:
        import torch

        found = self._tokenizer(text, return_offsets_mapping=True)
        ids = torch.tensor(found["input_ids"])
        own = [i for i, (a, b) in enumerate(found["offset_mapping"]) if a < end and b > start and b > a]
        copies = ids.repeat(len(own), 1)  # (k, T)
        copies[range(len(own)), own] = self._tokenizer.mask_token_id
        total = 0.0
        with torch.inference_mode():
            for first in range(0, len(own), self._batch):
                rows = copies[first : first + self._batch].to(self._model.device)
                logits = self._model(input_ids=rows, attention_mask=torch.ones_like(rows)).logits  # (k, T, V)
                places = own[first : first + self._batch]
                said = logits[range(len(places)), places].float().log_softmax(-1).cpu()
                total += float(said[range(len(places)), ids[places]].double().sum())
        return total / len(own)

    def _ids(self, text: str) -> list[int]:
        return list(self._tokenizer(text)["input_ids"])

    @cached_property
    def _window(self) -> int:
        """Longest text in tokens, including the special first and last ones."""
        positions = getattr(self._model.config, "max_position_embeddings", None) or 1 << 30
        return min(int(self._tokenizer.model_max_length), int(positions) - _UNUSED_POSITIONS)

    @cached_property
    def _model(self) -> Any:
        return self._weights.load("AutoModelForMaskedLM")

    @cached_property
    def _tokenizer(self) -> Any:
        import transformers

        tokenizer = self._weights.read(transformers.AutoTokenizer.from_pretrained)
        if not tokenizer.is_fast or tokenizer.mask_token_id is None:
            raise DataError(f"{self._weights.path}: expected a fast tokenizer (tokenizer.json) with a mask token")
        return tokenizer


def made_cloze(question: Question) -> str:
    """A cloze for a question without one: it lists the options and ends with the gap.

    Such as ``Of sofa, desk and shelf, the wallet is most likely at the {}.``
    """
    names = [option.name for option in question.options]
    listed = f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
    plain = listed.replace("{", "").replace("}", "")
    return f"Of {plain}, the {question.target} is most likely at the {{}}."
