"""What is usual where, learned from a dataset's own placements: p(anchor | target) before any habit is read.

The shipped common sense knows the habit book's anchors. A dataset with other names, as the official release, brings
its own: softmax regression on the target's sentence vector, among the anchors that its scene has.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ucon.core.errors import DataError
from ucon.habits.types import Entry
from ucon.retrieval.weights import Array, softmax


@dataclass(frozen=True, eq=False)
class AnchorPrior:
    """Softmax regression from a vector (D,) to A anchors."""

    names: tuple[str, ...]
    dense: Array  # (D, A)
    bias: Array  # (A,)

    def log_p(self, vectors: Array, names: Sequence[str], unknown: float) -> Array:
        """Log p (T, C) of names for target vectors (T, D); ``unknown`` for names that it does not know."""
        number = {name: i for i, name in enumerate(self.names)}
        known = np.log(softmax(np.round(vectors @ self.dense + self.bias, 4)))
        out = np.full((len(vectors), len(names)), unknown)
        for i, name in enumerate(names):
            if name in number:
                out[:, i] = known[:, number[name]]
        return out

    def to_bytes(self) -> bytes:
        """The weights, in float16."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, dense=self.dense.astype(np.float16), bias=self.bias.astype(np.float16))
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, raw: bytes, names: Sequence[str], where: str) -> AnchorPrior:
        """What :meth:`to_bytes` wrote.

        Raises:
            DataError: it is something else, or for other names.
        """
        try:
            with np.load(io.BytesIO(raw), allow_pickle=False) as file:
                dense, bias = (file[name].astype(np.float64) for name in ("dense", "bias"))
        except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise DataError(f"{where}: no anchor prior ({str(error)[:80]}); train the head again") from None
        if dense.ndim != 2 or bias.shape != (len(names),) or dense.shape[1:] != bias.shape:
            raise DataError(f"{where}: {dense.shape} for {len(names)} anchors; train the head again")
        return cls(tuple(names), dense, bias)


def scene_anchors(entries: Iterable[Entry]) -> dict[str, set[str]]:
    """Anchors that entries name, by the scene that they are bound to."""
    found: dict[str, set[str]] = {}
    for entry in entries:
        found.setdefault(entry.scene or "", set()).update(place.anchor for place in entry.placements)
    return found
