"""Evidence of sentences by an encoder that was fitted for it (:mod:`ucon.fitting.place_encoder`).

The same interface as :class:`~ucon.readers.evidence.EvidenceReader`, and far better on words that never occurred
with a place in training. Logits of the habit book's sentences are shipped; other sentences are encoded once, one at a
time, and kept in the user's cache.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.core.files import sha256_bytes
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.pairs import PairReader
from ucon.language.store import StoredEncoder, VectorTable
from ucon.readers.evidence import DECIMALS, EvidenceReader
from ucon.readers.reader_weights import Array, ReaderWeights, load_arrays

DATA: Final = Path(__file__).parent / "data" / "places"
ADAPTER: Final = DATA / "places.safetensors"
LAST: Final = DATA / "last.npz"
#: Path, without suffix, of the table of logits of the habit book's sentences.
TABLE: Final = DATA / "book"
#: Unit vectors are multiplied by this before the last layer.
SCALE: Final = 10.0


class TunedEvidence(EvidenceReader):
    """Evidence reader with an adapted encoder; sentences of the habit book are looked up in the shipped table."""

    def __init__(self, weights: ReaderWeights, pairs: PairReader, table: VectorTable | None) -> None:
        """Load the last layer; the encoder is loaded on first use.

        Args:
            weights: give the anchors, and read names outside the training data.
            pairs: encodes sentences and pairs.
            table: logits computed beforehand; None: every text is encoded.

        Raises:
            DataError: the last layer is missing, altered, or was made for other anchors.
        """
        super().__init__(weights, pairs)
        self.table = table
        self._last, self._sha256 = load_arrays(LAST)
        if tuple(self._last["anchors"].tobytes().decode().split("\n")) != weights.anchors:
            raise DataError(f"{LAST}: made for other anchors than the reader's; restore both from the release")
        self._encoder = StoredEncoder(AdaptedMiniLM(ADAPTER))

    @property
    def sha256(self) -> str:
        """Hash of last layer and adapter."""
        return sha256_bytes(f"{self._sha256} {self._encoder.name}".encode())

    def logits_of(self, texts: Sequence[str]) -> Array:
        """Logits (n, A + 5) of texts by the encoder, without the table."""
        return self.of_vectors(self._encoder.encode_half(texts), texts)

    def of_vectors(self, vectors: NDArray[np.float16], texts: Sequence[str]) -> Array:
        """Logits (n, A + 5) from vectors, rounded to 1e-4.

        Args:
            vectors: (n, D) float16 of the adapted encoder.
            texts: the n sentences, for pair features.
        """
        n = len(self.weights.anchors)
        out = vectors.astype(np.float64) @ self._last["dense"].astype(np.float64) + self._last["bias"]
        out[:, :n] += self.pairs.features(texts, self.weights.anchors).astype(np.float64) @ self._last["pair"]
        return np.round(out, DECIMALS)

    def _logits(self, texts: Sequence[str]) -> Array:
        rows = [-1 if self.table is None else self.table.row(text) for text in texts]
        out = np.empty((len(texts), len(self.weights.anchors) + 5))
        new = [i for i, row in enumerate(rows) if row < 0]
        if new:
            out[new] = self.logits_of([texts[i] for i in new])
        for i, row in enumerate(rows):
            if row >= 0 and self.table is not None:
                out[i] = self.table.vectors[row]
        return out


@cache
def book_table() -> VectorTable | None:
    """Table of logits of the habit book's sentences; None before it was made."""
    return VectorTable.load(TABLE) if TABLE.with_suffix(".npy").is_file() else None
