"""``vision_lm``: a chat model that sees; the score of an option is the log-probability that it is the answer.

As in :mod:`ucon.language.models.causal_lm`, an answer is the option's name and the end of the turn. Every option goes
through model and processor with the whole prompt: how images enter (cross-attention, patches among the tokens, places
in three dimensions) differs between models, and what each processor makes is right for its own.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, DataError
from ucon.language.choice import Answer, Image, Question, from_scores
from ucon.language.models.conversation import ChatTemplate, common_prefix, end_tokens, most_habits, window_of
from ucon.language.models.local import LocalModel
from ucon.language.models.weights import LocalWeights


class VisionModel(LocalModel):
    """Any AutoModelForImageTextToText whose processor has a chat template."""

    kind = "vision"
    sees_images = True

    def __init__(
        self,
        path: str,
        *,
        device: str = "cpu",
        dtype: str = "float32",
        batch_size: int = 4,
        normalise: bool = False,
        window: int | None = None,
        download: bool = False,
        template: Mapping[str, Any] | None = None,
    ) -> None:
        """Nothing is read before it is needed. Arguments and errors as in :class:`.causal_lm.CausalModel`."""
        if batch_size < 1 or (window is not None and window < 2):
            raise ConfigError(f"batch_size={batch_size}, window={window}: expected at least 1 and 2")
        super().__init__(LocalWeights(path, device=device, dtype=dtype, download=download))
        self._batch, self._normalise, self._limit, self._options = batch_size, normalise, window, template

    def _answer(self, question: Question) -> Answer:
        start = time.perf_counter()
        names = [option.name.encode("utf-8", "replace").decode() or "?" for option in question.options]
        longest = max(len(self._tokenizer(name, add_special_tokens=False)["input_ids"]) for name in names)

        def length(system: str) -> int:
            return len(self._inputs([self._prompt(system, question)], question.images)["input_ids"][0])

        found = most_habits(question.system, lambda system: length(system) + longest <= self._window)
        if found is None:
            return Answer(-1, failure="too long", seconds=time.perf_counter() - start)
        prompt = self._prompt(found[0], question)
        tokens = self._inputs([prompt], question.images)["input_ids"][0].tolist()
        scores = self._log_probs(prompt, tokens, names, question.images)
        spent = time.perf_counter() - start
        return from_scores(scores, prompt_tokens=len(tokens), seconds=spent, dropped=found[1])

    def _prompt(self, system: str, question: Question) -> str:
        text = self._template.render(system, question.situation, len(question.images))
        return text.encode("utf-8", "replace").decode()

    def _log_probs(
        self, prompt: str, tokens: Sequence[int], names: Sequence[str], images: Sequence[Image]
    ) -> NDArray[np.float64]:
        """Log-probability (n,) of each name and the end of the turn after a prompt of these tokens."""
        parts = [names[i : i + self._batch] for i in range(0, len(names), self._batch)]
        batches = [self._inputs([prompt + name for name in part], images) for part in parts]
        rows = [_rows(inputs) for inputs in batches]
        # Where a name's first letters change how the prompt's end is cut into tokens, all scores start before them.
        first = min(common_prefix(tokens, row) for part in rows for row in part)
        return np.concatenate([self._scored(*pair, first) for pair in zip(batches, rows, strict=True)])

    def _scored(self, inputs: dict[str, Any], rows: Sequence[Sequence[int]], first: int) -> NDArray[np.float64]:
        """Log-probability (n,) of each row's tokens from number ``first`` on, and of the end of the turn."""
        import torch

        width = inputs["input_ids"].shape[1]
        with torch.inference_mode():
            moved = {name: self._moved(value) for name, value in inputs.items()}
            logits = self._model(**moved, use_cache=False, logits_to_keep=width - first + 1).logits
        said = logits[:, first - 1 - width :].float().log_softmax(-1).cpu()  # (n, width - first + 1, V)
        out = np.empty(len(rows))
        for i, row in enumerate(rows):
            own = list(row[first:])
            end = said[i, len(own), self._ends].double().logsumexp(0)
            total = float(said[i, range(len(own)), own].double().sum() + end)
            out[i] = total / (len(own) + 1 if self._normalise else 1)
        return out

    def _inputs(self, texts: Sequence[str], images: Sequence[Image]) -> dict[str, Any]:
        """What the processor makes of texts that all go with the same images."""
        from PIL import Image as Picture

        seen = [[Picture.fromarray(image) for image in images] for _ in texts] if images else None
        return dict(
            self._processor(text=list(texts), images=seen, return_tensors="pt", padding=True, add_special_tokens=False)
        )

    def _moved(self, value: Any) -> Any:
        """A tensor on the model's device; numbers with a fraction as the model's."""
        value = value.to(self._model.device)
        return value.to(self._model.dtype) if value.is_floating_point() else value

    @cached_property
    def _window(self) -> int:
        return min(window_of(self._model), self._limit or 1 << 30)

    @cached_property
    def _ends(self) -> list[int]:
        return end_tokens(self._model, self._tokenizer)

    @cached_property
    def _template(self) -> ChatTemplate:
        return ChatTemplate(self._processor, self._weights.path, self._options)

    @cached_property
    def _model(self) -> Any:
        return self._weights.load("AutoModelForImageTextToText")

    @cached_property
    def _tokenizer(self) -> Any:
        return self._processor.tokenizer

    @cached_property
    def _processor(self) -> Any:
        import transformers

        processor = self._weights.read(transformers.AutoProcessor.from_pretrained)
        if not hasattr(processor, "image_processor") or getattr(processor, "tokenizer", None) is None:
            raise DataError(f"{self._weights.path}: no processor of images and text; choose a model that sees")
        processor.tokenizer.padding_side = "right"
        if processor.tokenizer.pad_token is None:
            processor.tokenizer.pad_token = processor.tokenizer.eos_token
        return processor


def _rows(inputs: Mapping[str, Any]) -> list[list[int]]:
    """The tokens of each text, without what pads them."""
    pairs = zip(inputs["input_ids"], inputs["attention_mask"], strict=True)
    return [row[there.bool()].tolist() for row, there in pairs]
