"""Rows of tokens through a causal network, each after its own past (kept keys and values of the tokens before).

Pasts of different lengths are aligned at their ends; padding on the left is masked. New tokens are padded on the right,
where no real token can see them. So a row's own keys are one contiguous stretch, which is cut out again for the next
tokens, and its tokens have the positions that they would have alone.
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Sequence
from typing import Any, Final

Past = Any
"""A cache of transformers that holds one row."""

#: Rotary embeddings whose frequencies depend on the longest row that is read.
_LENGTH_DEPENDENT: Final = ("dynamic", "longrope")


class PrefixReader:
    """Reads rows of tokens after pasts; pasts are never changed.

    Attributes:
        together: whether pasts of different lengths may be batched.
    """

    def __init__(self, model: Any, pad: int) -> None:
        """Take over a model.

        Args:
            model: a causal model of transformers.
            pad: any token; no score depends on it.
        """
        self._model, self._pad = model, pad
        self.together = reads_together(model)

    def nothing(self) -> Past:
        """The past before the first token."""
        from transformers import DynamicCache

        return DynamicCache(config=self._model.config)

    def after(self, pasts: Sequence[Past], rows: Sequence[Sequence[int]]) -> list[Past]:
        """The pasts after further tokens.

        Args:
            pasts: n pasts; several only where ``together``.
            rows: n rows of tokens; rows may be empty.
        """
        if not any(rows):
            return list(pasts)
        _, cache = self._read(pasts, rows, last=1)
        if len(rows) == 1:
            return [cache]
        held = [past.get_seq_length() for past in pasts]
        longest = max(held)
        ends = [longest + len(row) for row in rows]
        return [self._cut(cache, i, longest - held[i], ends[i]) for i in range(len(rows))]

    def logits(self, pasts: Sequence[Past], rows: Sequence[Sequence[int]]) -> Any:
        """Logits after each token of the rows.

        Args:
            pasts: n pasts; several only where ``together``.
            rows: n rows of up to T tokens.

        Returns:
            (n, T, V) float32.
        """
        return self._read(pasts, rows, last=max(map(len, rows)))[0]

    def _read(self, pasts: Sequence[Past], rows: Sequence[Sequence[int]], *, last: int) -> tuple[Any, Past]:
        """Logits (n, last, V) and the new cache of all rows, with their padding."""
        import torch

        width = max(map(len, rows))
        padded = [[*row, *[self._pad] * (width - len(row))] for row in rows]
        ids = torch.tensor(padded, device=self._model.device)
        cache = self._side_by_side(pasts)
        told = self._places(pasts, rows) if self.together else {}
        out = self._model(input_ids=ids, past_key_values=cache, use_cache=True, logits_to_keep=last, **told)
        return out.logits[:, -last:].float(), cache

    def _places(self, pasts: Sequence[Past], rows: Sequence[Sequence[int]]) -> dict[str, Any]:
        """Positions (n, T) int64 of the tokens, and the mask (n, S + T) int64 of what stands before and among them.

        What pads a row on the right shares its last position: beyond it a table of positions may end.
        """
        import torch

        held = torch.tensor([past.get_seq_length() for past in pasts])[:, None]
        own = torch.tensor([max(len(row), 1) for row in rows])[:, None]
        longest, width = int(held.max()), int(own.max())
        positions = held + torch.arange(width).minimum(own - 1)
        seen = torch.arange(longest + width) >= longest - held
        device = self._model.device
        return {"position_ids": positions.to(device), "attention_mask": seen.long().to(device)}

    def _side_by_side(self, pasts: Sequence[Past]) -> Past:
        """A new cache of a row each, ends aligned."""
        import torch

        if all(past is pasts[0] for past in pasts):
            cache = copy.deepcopy(pasts[0])
            # By selecting, not repeating, which recurrent states do not know.
            cache.reorder_cache(torch.zeros(len(pasts), dtype=torch.long, device=self._model.device))
            return cache
        held = [past.get_seq_length() for past in pasts]
        cache, longest = self.nothing(), max(held)
        like = pasts[held.index(longest)]
        for n in range(len(cache.layers) if longest else 0):
            both = []
            for name in ("keys", "values"):
                whole = getattr(like.layers[n], name)  # (1, H, S, D)
                rows = whole.new_zeros(len(pasts), *whole.shape[1:])
                for row, past, length in zip(rows, pasts, held, strict=True):
                    if length:
                        row[:, longest - length :] = getattr(past.layers[n], name)[0]
                both.append(rows)
            cache.update(*both, n)
        return cache

    def _cut(self, cache: Past, row: int, start: int, stop: int) -> Past:
        """The past of one row; a copy, so that the others' memory is given back."""
        out = self.nothing()
        for n, layer in enumerate(cache.layers):
            out.update(layer.keys[row : row + 1, :, start:stop], layer.values[row : row + 1, :, start:stop], n)
        return out


def reads_together(model: Any) -> bool:
    """Whether rows with pasts of different lengths may be batched.

    Every layer must keep all keys and values and nothing else. A sliding window keeps the last ones of the padded row,
    a recurrent state includes the padding, and a shared layer keeps none. The model must also accept positions and
    mask.
    """
    from transformers import DynamicCache
    from transformers.cache_utils import DynamicLayer

    layers = DynamicCache(config=model.config).layers
    told = inspect.signature(model.forward).parameters.keys() >= {"position_ids", "attention_mask"}
    return told and all(type(layer) is DynamicLayer for layer in layers) and rows_are_independent(model)


def rows_are_independent(model: Any) -> bool:
    """Whether a row's positions mean the same beside longer rows.

    They do not where the longest row sets the frequencies of the rotary embedding.
    """
    found = getattr(model.config.get_text_config(decoder=True), "rope_parameters", None) or {}
    # One set of parameters, or one for each type of layer.
    sets = [found, *(value for value in found.values() if isinstance(value, dict))]
    return not any(one.get("rope_type") in _LENGTH_DEPENDENT for one in sets)
