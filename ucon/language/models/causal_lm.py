"""``causal_lm``: a chat model on this machine; the score of an option is the log-probability that it is the answer.

The answer is the option's name and then the end of the turn. Without the end, ``sofa`` would be at least as probable
as ``sofa bed``, which begins with it. Log-probabilities are summed over tokens: that of the whole answer is what the
model says, and over the closed set they add up after division. ``normalise`` takes the mean instead, for models that
give long names too little.

The system part is the same in all questions of an episode, so its keys and values are kept; those of a question are
computed once and shared by its options.
"""

from __future__ import annotations

import copy
import time
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.language.choice import Answer, Question, from_scores
from ucon.language.models.conversation import ChatTemplate, common_prefix, end_tokens, most_habits, window_of
from ucon.language.models.local import LocalModel
from ucon.language.models.weights import LocalWeights

Ids = tuple[int, ...]

#: Two users' texts that begin differently: what their conversations share is the system's part.
_USERS: Final = ("A", "?")


class CausalModel(LocalModel):
    """Any AutoModelForCausalLM whose tokenizer has a chat template."""

    kind = "causal"

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
    ) -> None:
        """Nothing is read before it is needed.

        Args:
            path: folder in Hugging Face layout, or a name in the Hugging Face cache.
            device: ``cpu``, ``cuda``, ``auto``.
            dtype: ``float32``, ``bfloat16``, ``float16``, ``int8``.
            batch_size: options that go through the network together.
            prefixes: system parts whose keys and values are kept; one an episode played side by side.
            normalise: mean log-probability of the answer's tokens instead of their sum.
            window: longest prompt and answer in tokens; by default what the model can hold.
            download: get a name that is not in the cache from the hub.
            template: options of the chat template, such as ``enable_thinking: false``.

        Raises:
            ConfigError: a number out of range, an unknown dtype.
        """
        if batch_size < 1 or prefixes < 0 or (window is not None and window < 2):
            raise ConfigError(
                f"batch_size={batch_size}, prefixes={prefixes}, window={window}: expected at least 1, 0 and 2"
            )
        super().__init__(LocalWeights(path, device=device, dtype=dtype, download=download))
        self._batch, self._keep, self._normalise, self._limit = batch_size, prefixes, normalise, window
        self._options = template
        self._prefixes: OrderedDict[Ids, Any] = OrderedDict()
        self._systems: OrderedDict[str, Ids] = OrderedDict()

    def _answer(self, question: Question) -> Answer:
        start = time.perf_counter()
        answers = [self._ids(option.name) or self._ids("?") for option in question.options]
        room = self._window - max(map(len, answers))
        found = most_habits(question.system, lambda system: len(self._prompt(system, question.situation)) <= room)
        if found is None:
            return Answer(-1, failure="too long", seconds=time.perf_counter() - start)
        system, dropped = found
        prompt = self._prompt(system, question.situation)
        scores = self._log_probs(self._system_part(system), prompt, answers)
        spent = time.perf_counter() - start
        return from_scores(scores, prompt_tokens=len(prompt), seconds=spent, dropped=dropped)

    def _prompt(self, system: str, situation: str) -> Ids:
        return self._ids(self._template.render(system, situation))

    def _ids(self, text: str) -> Ids:
        """Tokens of a text that carries its special ones itself."""
        clean = text.encode("utf-8", "replace").decode()
        return tuple(self._tokenizer(clean, add_special_tokens=False)["input_ids"])

    def _system_part(self, system: str) -> Ids:
        """Tokens with which every conversation of this system begins."""
        if system not in self._systems:
            a, b = (self._prompt(system, user) for user in _USERS)
            self._systems[system] = a[: common_prefix(a, b)]
            if len(self._systems) > max(self._keep, 1):
                self._systems.popitem(last=False)
        return self._systems[system]

    def _log_probs(self, shared: Ids, prompt: Ids, answers: Sequence[Ids]) -> NDArray[np.float64]:
        """Log-probability (n,) of each answer and the end of the turn after a prompt."""
        import torch

        with torch.inference_mode():
            # At least one token of the prompt is left to be read, for what it says about the next.
            shared = shared[: min(common_prefix(shared, prompt), len(prompt) - 1)]
            cache = copy.deepcopy(self._prefix(shared)) if shared and self._keep else self._no_cache()
            first = self._read([prompt[len(shared) if self._keep else 0 :]], cache, last=1)[0, -1]
            parts = [answers[i : i + self._batch] for i in range(0, len(answers), self._batch)]
            return np.concatenate([self._continued(cache, first, part) for part in parts])

    def _continued(self, cache: Any, first: Any, answers: Sequence[Ids]) -> NDArray[np.float64]:
        """Log-probabilities (n,) of answers; ``first`` (V,) says the first token, ``cache`` holds the prompt."""
        import torch

        longest = max(map(len, answers))
        # What is padded stands after the answer, so no token that counts can see it.
        rows = [answer + (self._ends[0],) * (longest - len(answer)) for answer in answers]
        mine = copy.deepcopy(cache)
        mine.batch_repeat_interleave(len(rows))
        later = self._read(rows, mine, last=longest)  # (n, T, V)
        said = torch.cat([first.expand(len(rows), 1, -1), later], 1).log_softmax(-1).cpu()  # (n, T + 1, V)
        out = np.empty(len(rows))
        for i, answer in enumerate(answers):
            tokens = said[i, range(len(answer)), list(answer)].double().sum()
            end = said[i, len(answer), self._ends].double().logsumexp(0)
            out[i] = float(tokens + end) / (len(answer) + 1 if self._normalise else 1)
        return out

    def _prefix(self, ids: Ids) -> Any:
        """Keys and values of a system part: kept for the last few."""
        if ids not in self._prefixes:
            cache = self._no_cache()
            self._read([ids], cache, last=1)
            self._prefixes[ids] = cache
            if len(self._prefixes) > self._keep:
                self._prefixes.popitem(last=False)
        self._prefixes.move_to_end(ids)
        return self._prefixes[ids]

    def _read(self, rows: Sequence[Ids], cache: Any, *, last: int) -> Any:
        """Logits (n, last, V) float32 of rows of tokens after what ``cache`` holds, which grows by them."""
        import torch

        ids = torch.tensor(rows, device=self._model.device)
        out = self._model(input_ids=ids, past_key_values=cache, use_cache=True, logits_to_keep=last)
        return out.logits[:, -last:].float()

    def _no_cache(self) -> Any:
        from transformers import DynamicCache

        return DynamicCache(config=self._model.config)

    @cached_property
    def _window(self) -> int:
        return min(window_of(self._model), self._limit or 1 << 30)

    @cached_property
    def _ends(self) -> list[int]:
        return end_tokens(self._model, self._tokenizer)

    @cached_property
    def _template(self) -> ChatTemplate:
        return ChatTemplate(self._tokenizer, self._weights.path, self._options)

    @cached_property
    def _model(self) -> Any:
        return self._weights.load("AutoModelForCausalLM")

    @cached_property
    def _tokenizer(self) -> Any:
        import transformers

        return self._weights.read(transformers.AutoTokenizer.from_pretrained)
