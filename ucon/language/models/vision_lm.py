"""``vision_lm``: a vision chat model on this machine, scored by :mod:`ucon.language.models.likelihood`.

Every option goes through processor and model with the whole prompt. How images enter (cross-attention, patches among
the tokens, positions in three dimensions) differs between models, and a model's own processor prepares them correctly.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.language.choice import Image, Question
from ucon.language.models.conversation import common_prefix, most_habits
from ucon.language.models.likelihood import LikelihoodModel, Ready
from ucon.language.models.reading import rows_are_independent
from ucon.language.models.weights import LocalWeights


@dataclass(frozen=True, eq=False)
class _Ready(Ready):
    text: str
    """The prompt before the processor inserts image tokens."""
    names: tuple[str, ...]
    images: tuple[Image, ...]


class VisionModel(LikelihoodModel[_Ready]):
    """Any AutoModelForImageTextToText whose processor has a chat template."""

    kind = "vision"
    auto = "AutoModelForImageTextToText"
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
        """Choose model and options; nothing is read yet.

        See :class:`.causal_lm.CausalModel` for arguments and errors.
        """
        weights = LocalWeights(path, device=device, dtype=dtype, download=download)
        super().__init__(weights, batch_size=batch_size, normalise=normalise, window=window, template=template)

    def _ready(self, question: Question) -> _Ready | None:
        names = tuple(option.name.encode("utf-8", "replace").decode() or "?" for option in question.options)
        longest = max(len(self._tokenizer(name, add_special_tokens=False)["input_ids"]) for name in names)

        def tokens(system: str) -> list[int]:
            return _rows(self._inputs([self._prompt(system, question)], [question.images]))[0]

        found = most_habits(question.system, lambda system: len(tokens(system)) + longest <= self._window)
        if found is None:
            return None
        system, dropped = found
        return _Ready(tuple(tokens(system)), dropped, self._prompt(system, question), names, question.images)

    def _prompt(self, system: str, question: Question) -> str:
        text = self._template.render(system, question.situation, len(question.images))
        return text.encode("utf-8", "replace").decode()

    def _kind(self, ready: _Ready) -> Hashable:
        """Number and sizes of the images: processors differ in how they pad images of different sizes."""
        return tuple(image.shape for image in ready.images)

    def _scores(self, group: Sequence[_Ready]) -> list[NDArray[np.float64]]:
        parts = self._parts([one.names for one in group])
        batches = [
            self._inputs([group[k].text + name for k, name in part], [group[k].images for k, _ in part])
            for part in parts
        ]
        rows = [_rows(inputs) for inputs in batches]
        # A name's first letters may change how the end of the prompt is tokenised; then scores start before that token.
        first = [len(one.prompt) for one in group]
        for part, own in zip(parts, rows, strict=True):
            for (k, _), row in zip(part, own, strict=True):
                first[k] = min(first[k], common_prefix(group[k].prompt, row))
        out: list[list[float]] = [[] for _ in group]
        for part, own, inputs in zip(parts, rows, batches, strict=True):
            scores = self._scored(inputs, own, [first[k] for k, _ in part])
            for (k, _), score in zip(part, scores, strict=True):
                out[k].append(score)
        return [np.array(scores) for scores in out]

    def _scored(self, inputs: dict[str, Any], rows: Sequence[Sequence[int]], first: Sequence[int]) -> list[float]:
        """Log-probability of each row's tokens from number ``first`` on, and of the end of the turn."""
        import torch

        # The vocabulary is large, so logits are computed only at the positions of answers.
        places = sorted({place for row, start in zip(rows, first, strict=True) for place in range(start - 1, len(row))})
        with torch.inference_mode():
            moved = {name: self._moved(value) for name, value in inputs.items()}
            keep = torch.tensor(places, device=self._model.device)
            logits = self._model(**moved, use_cache=False, logits_to_keep=keep).logits
            if logits.shape[1] != len(places):  # models without this option return all positions
                logits = logits[:, keep]
            said = logits.float().log_softmax(-1).cpu()  # (n, len(places), V)
        own = zip(said, rows, first, strict=True)
        return [self._log_prob(one[places.index(start - 1) :], row[start:]) for one, row, start in own]

    def _inputs(self, texts: Sequence[str], images: Sequence[Sequence[Image]]) -> dict[str, Any]:
        """The processor's output for texts and their images; either all texts have images or none has."""
        from PIL import Image as Picture

        seen = [[Picture.fromarray(image) for image in own] for own in images] if any(images) else None
        return dict(
            self._processor(text=list(texts), images=seen, return_tensors="pt", padding=True, add_special_tokens=False)
        )

    def _moved(self, value: Any) -> Any:
        """A tensor on the model's device, and in the model's dtype if it is floating-point."""
        value = value.to(self._model.device)
        return value.to(self._model.dtype) if value.is_floating_point() else value

    @cached_property
    def _together(self) -> bool:
        return rows_are_independent(self._model)

    @property
    def _owner(self) -> Any:
        return self._processor

    @property
    def _tokenizer(self) -> Any:
        return self._processor.tokenizer

    @cached_property
    def _processor(self) -> Any:
        import transformers

        processor = self._weights.read(transformers.AutoProcessor.from_pretrained)
        if not hasattr(processor, "image_processor") or getattr(processor, "tokenizer", None) is None:
            raise DataError(f"{self._weights.path}: no processor for images and text; choose a vision-language model")
        processor.tokenizer.padding_side = "right"
        if processor.tokenizer.pad_token is None:
            processor.tokenizer.pad_token = processor.tokenizer.eos_token
        return processor


def _rows(inputs: Mapping[str, Any]) -> list[list[int]]:
    """The tokens of each text, without padding."""
    pairs = zip(inputs["input_ids"], inputs["attention_mask"], strict=True)
    return [row[there.bool()].tolist() for row, there in pairs]
