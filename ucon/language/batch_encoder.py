"""The sentence encoder in batches and with gradients, for training."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from ucon.core.device import cpu_precision

CHUNK = 40
"""Texts per pass. Texts are sorted by length, so that there is little padding."""
MAX_TOKENS = 64


class BatchEncoder:
    """Encodes many texts at once, with gradients. The last bits depend on the batch, so it is for training only."""

    def __init__(self, tokenizer: Any, model: Any, precision: torch.dtype) -> None:
        """Set tokenizer and model.

        Args:
            tokenizer: of transformers.
            model: of transformers.
            precision: of the matrix products.
        """
        self._tokenizer, self._model, self._precision = tokenizer, model, cpu_precision(precision)

    def __call__(self, texts: Sequence[str], hidden: float = 0.0, seed: int = 0) -> Tensor:
        """Encode texts.

        Args:
            texts: n sentences.
            hidden: share of tokens that are masked, so that training cannot rely on single words.
            seed: of the masks.

        Returns:
            (n, dim) float32 unit vectors, in the order of ``texts``.
        """
        ids = self._tokenizer(list(texts), truncation=True, max_length=MAX_TOKENS)["input_ids"]
        if hidden:
            ids = self._masked(ids, hidden, np.random.default_rng(seed))
        order = sorted(range(len(texts)), key=lambda i: (len(ids[i]), i))
        parts = [self._pass([ids[i] for i in order[at : at + CHUNK]]) for at in range(0, len(order), CHUNK)]
        place = torch.empty(len(order), dtype=torch.long)
        place[order] = torch.arange(len(order))
        return torch.cat(parts)[place]

    def _masked(self, ids: list[list[int]], share: float, rng: np.random.Generator) -> list[list[int]]:
        """``ids`` with a share of tokens masked, but never a text's first and last (its special tokens)."""
        mask, out = self._tokenizer.mask_token_id, []
        for one in ids:
            hide = rng.random(len(one)) < share
            hide[[0, -1]] = False
            out.append([mask if gone else token for token, gone in zip(one, hide, strict=True)])
        return out

    def _pass(self, ids: list[list[int]]) -> Tensor:
        inputs = self._tokenizer.pad({"input_ids": ids}, return_tensors="pt")
        with torch.autocast("cpu", self._precision, enabled=self._precision != torch.float32):
            hidden = self._model(**inputs).last_hidden_state.float()  # (n, T, dim)
        mask = inputs["attention_mask"][..., None]
        return torch.nn.functional.normalize((hidden * mask).sum(1) / mask.sum(1), dim=1)
