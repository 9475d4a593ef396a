"""A dataset's own prior p(anchor | target), before any habit is read, fitted on its placements.

The shipped prior knows the habit book's anchors. A dataset with other names, such as the official release, has its own:
softmax regression on the target's name vector, among the anchors of its scene.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ucon.core.errors import DataError
from ucon.core.untrusted.unpack import MAX_BYTES, read_arrays
from ucon.habits.types import Entry
from ucon.objects.model import RELATIONS
from ucon.readers.reader_weights import Array, softmax

#: Log-probability given to a name outside the prior.
UNKNOWN_PRIOR: Final = -7.5
_KEPT: Final = ("dense", "bias", "relation")


@dataclass(frozen=True, eq=False)
class AnchorPrior:
    """Softmax regression from a name vector (D,) to A anchors, with a distribution over relations for each anchor."""

    names: tuple[str, ...]
    """The A anchors."""
    dense: Array
    """(D, A) weights."""
    bias: Array
    """(A,)."""
    relation: Array
    """(A, 4) p(relation | anchor)."""

    @cached_property
    def relations(self) -> dict[str, Array]:
        """p(relation | anchor), (4,), by anchor."""
        return dict(zip(self.names, self.relation, strict=True))

    def log_p(self, vectors: Array, names: Sequence[str], unknown: float) -> Array:
        """Log-probabilities of names for T targets.

        Args:
            vectors: (T, D) vectors of the targets' names.
            names: C names.
            unknown: value for names outside the prior.

        Returns:
            (T, C) float64.
        """
        number = {name: i for i, name in enumerate(self.names)}
        known = np.log(softmax(np.round(vectors @ self.dense + self.bias, 4)))
        out = np.full((len(vectors), len(names)), unknown)
        for i, name in enumerate(names):
            if name in number:
                out[:, i] = known[:, number[name]]
        return out

    def to_bytes(self) -> bytes:
        """The arrays as a compressed npz file in float16; the names are not in it."""
        buffer = io.BytesIO()
        half = {name: getattr(self, name).astype(np.float16) for name in _KEPT}
        np.savez_compressed(buffer, **half)  # type: ignore[arg-type]
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, raw: bytes, names: Sequence[str], where: str) -> AnchorPrior:
        """Read what :meth:`to_bytes` wrote.

        Args:
            raw: content of the file; not trusted.
            names: the A anchors.
            where: names the file in errors.

        Raises:
            DataError: it has another form, values that are not finite, or arrays for another number of anchors.
        """
        try:
            file = read_arrays(raw, MAX_BYTES)
            dense, bias, relation = (file[name].astype(np.float64) for name in _KEPT)
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(f"{where}: no anchor prior ({str(error)[:80]}); train the head again") from None
        if not all(np.isfinite(array).all() for array in (dense, bias, relation)):
            raise DataError(f"{where}: values that are not finite; train the head again")
        shapes = dense.shape[1:] == bias.shape == (len(names),) and relation.shape == (len(names), len(RELATIONS))
        if dense.ndim != 2 or not shapes:
            raise DataError(f"{where}: {dense.shape} for {len(names)} anchors; train the head again")
        return cls(tuple(names), dense, bias, relation)


def scene_anchors(entries: Iterable[Entry]) -> dict[str, set[str]]:
    """Anchors that entries name in their placements, by scene."""
    found: dict[str, set[str]] = {}
    for entry in entries:
        found.setdefault(entry.scene or "", set()).update(place.anchor for place in entry.placements)
    return found
