"""Runs rows of tokens through a causal network, each after its own past (cached keys and values of earlier tokens).

Pasts of different lengths are aligned at their ends; padding on the left is masked. New tokens are padded on the right,
where no real token can see them. So a row's own keys are one contiguous stretch, which is cut out again for the next
tokens, and its tokens have the positions that they would have alone.

A row may fork: several answers follow one prompt, and a mask keeps each from seeing the others. So a prompt is read
once for all its answers, and the past before it is not copied for each.
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Sequence
from functools import partial
from itertools import accumulate, pairwise
from typing import Any, Final

Ids = Sequence[int]
Past = Any
"""A cache of transformers that holds one row."""

#: Implementations of attention that take a mask of any form.
_MASKED: Final = ("sdpa", "eager")
#: Rotary embeddings whose frequencies depend on the longest row that is read.
_LENGTH_DEPENDENT: Final = ("dynamic", "longrope")


class PrefixReader:
    """Reads rows of tokens after pasts; pasts are never changed.

    Attributes:
        together: whether pasts of different lengths may be batched.
        forking: whether :meth:`forked` may be used.
    """

    def __init__(self, model: Any, pad: int) -> None:
        """Set the model.

        Args:
            model: a causal model of transformers.
            pad: any token; no score depends on it.
        """
        self._model, self._pad = model, pad
        self.together = reads_together(model)
        self.forking = self.together and model.config._attn_implementation in _MASKED

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

    def forked(
        self, pasts: Sequence[Past], prompts: Sequence[Ids], answers: Sequence[Sequence[Ids]]
    ) -> list[list[Any]]:
        """Logits of answers, each after the past and the prompt of its row; only where ``forking``.

        Args:
            pasts: n pasts.
            prompts: n prompts of at least one token.
            answers: any number for each row.

        Returns:
            For each row and answer (tokens + 1, V) float32: after the prompt, and after each token of the answer.
        """
        import torch

        tails = [sum(map(len, row)) for row in answers]
        width = max(len(prompt) + tail for prompt, tail in zip(prompts, tails, strict=True))
        held = torch.tensor([past.get_seq_length() for past in pasts])[:, None]
        rows = map(partial(self._fork, width), prompts, answers)
        ids, branch, after = (torch.tensor(part) for part in zip(*rows, strict=True))
        out = self._model(
            input_ids=ids.to(self._model.device),
            past_key_values=self._side_by_side(pasts),
            use_cache=True,
            logits_to_keep=max(tails) + 1,
            position_ids=(held + after).to(self._model.device),
            attention_mask=self._fork_mask(held, branch),
        ).logits[:, -max(tails) - 1 :]
        return [_by_answer(row[-tail - 1 :].float(), own) for row, tail, own in zip(out, tails, answers, strict=True)]

    def _fork(self, width: int, prompt: Ids, answers: Sequence[Ids]) -> tuple[list[int], list[int], list[int]]:
        """A row of ``width`` tokens, padded on the left; the branch of each token, and its position after the past.

        The prompt is branch 0, which all tokens see; answers count from 1; padding is -1 and sees no other branch.
        """
        ids, branch, after = list(prompt), [0] * len(prompt), list(range(len(prompt)))
        for number, answer in enumerate(answers, 1):
            ids += answer
            branch += [number] * len(answer)
            after += range(len(prompt), len(prompt) + len(answer))
        padding = width - len(ids)
        return [self._pad] * padding + ids, [-1] * padding + branch, [0] * padding + after

    def _fork_mask(self, held: Any, branch: Any) -> Any:
        """What the tokens of forked rows see: an additive mask (n, 1, T, S + T) of the model's type.

        Args:
            held: (n, 1) int64, lengths of the pasts.
            branch: (n, T) int64, see :meth:`_fork`.
        """
        import torch

        longest, width = int(held.max()), branch.shape[1]
        before = torch.arange(longest) >= longest - held  # (n, S)
        earlier = torch.ones(width, width, dtype=torch.bool).tril()
        new = earlier & ((branch[:, None, :] == 0) | (branch[:, None, :] == branch[:, :, None]))  # (n, T, T)
        seen = torch.cat([before[:, None, :].expand(-1, width, -1), new], dim=2)[:, None]
        least = torch.finfo(self._model.dtype).min
        return torch.zeros(seen.shape, dtype=self._model.dtype).masked_fill(~seen, least).to(self._model.device)

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
        """Positions (n, T) int64 of the tokens, and the mask (n, S + T) int64 of pasts and tokens.

        Padding on the right has the position of the row's last token: a table of positions may end there.
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
        """A new cache with one row per past, aligned at their ends."""
        import torch

        if len(pasts) == 1 and self.together and pasts[0].get_seq_length():
            return self._cut(pasts[0], 0, 0, None)  # new tokens are appended to this copy
        if all(past is pasts[0] for past in pasts):
            cache = copy.deepcopy(pasts[0])
            # Rows are selected, not repeated: caches of recurrent states cannot repeat.
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

    def _cut(self, cache: Past, row: int, start: int, stop: int | None) -> Past:
        """The past of one row; a copy, so that the memory of the other rows is freed."""
        out = self.nothing()
        for n, layer in enumerate(cache.layers):
            out.update(layer.keys[row : row + 1, :, start:stop], layer.values[row : row + 1, :, start:stop], n)
        return out


def _by_answer(logits: Any, answers: Sequence[Ids]) -> list[Any]:
    """Logits (T, V) of a prompt's last token and all answers, taken apart; the first row belongs to every answer."""
    import torch

    ends = list(accumulate(map(len, answers), initial=1))
    return [torch.cat([logits[:1], logits[start:end]]) for start, end in pairwise(ends)]


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
    """Whether a row's positions mean the same in a batch with longer rows.

    They do not where the longest row sets the frequencies of the rotary embedding.
    """
    found = getattr(model.config.get_text_config(decoder=True), "rope_parameters", None) or {}
    # One set of parameters, or one for each type of layer.
    sets = [found, *(value for value in found.values() if isinstance(value, dict))]
    return not any(one.get("rope_type") in _LENGTH_DEPENDENT for one in sets)
