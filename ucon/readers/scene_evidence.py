"""Evidence from sentences of a dataset with its own anchors, by an encoder fitted on where its things are kept.

The habit book says which placement every sentence supports. A dataset such as the official release says where a thing
is kept and lists its people's habits, but not which sentence says so; :mod:`ucon.fitting.scene_evidence` learns from
that. Every sentence and every name is read by itself, so any name can be asked about, and evidence does not change when
further names or sentences are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.core.files import read_verified, sha256_bytes
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.pairs import N_FEATURES, PairReader
from ucon.language.phrases import phrase
from ucon.language.store import StoredEncoder
from ucon.readers.evidence import DECIMALS, REMEMBERED, Evidence, EvidenceReader
from ucon.readers.reader_weights import Array, load_arrays, sigmoid

ADAPTER: Final = "places.safetensors"
LAST: Final = "places.npz"
#: Arrays of :data:`LAST`: lists of names (as bytes) and weights.
ARRAYS: Final = ("anchors", "added", "bias", "turn", "silence", "silence_bias", "pair", "owners", "ask", "owner_pair")
#: Unit vectors are multiplied by this before the last layer.
SCALE: Final = 10.0
#: Number of categories of a household; a sentence is about one of them.
_HOUSEHOLD: Final = 20
#: Number of targets whose relevance is cached.
_ASKED: Final = 64


class Vectors(Protocol):
    """Gives sentence vectors."""

    def encode_half(self, texts: Sequence[str]) -> NDArray[np.float16]:
        """Unit vectors (n, D) float16 of texts."""
        ...


class SceneEvidence:
    """Evidence reader of a dataset with anchors of its own.

    Attributes:
        known: anchors in its training data, sorted.
        files: content of the files that it was loaded from, by name.
    """

    def __init__(
        self, arrays: dict[str, NDArray[np.generic]], sha256: str, vectors: Vectors, pairs: PairReader,
        relations: EvidenceReader,
    ) -> None:  # fmt: skip
        """Combine the parts.

        Args:
            arrays: those of :data:`ARRAYS`.
            sha256: hash of everything that was fitted.
            vectors: sentence vectors of the adapted encoder.
            pairs: pair features.
            relations: reads the relation that a sentence speaks of.

        Raises:
            DataError: arrays are missing or do not fit together.
        """
        if missing := [name for name in ARRAYS if name not in arrays]:
            raise DataError(f"{LAST}: no {', '.join(missing)}; train the head again (learner=belief)")
        self.sha256, self.pairs = sha256, pairs
        self.files: dict[str, bytes] = {}
        self._vectors, self._relations = vectors, relations
        self.known = tuple(arrays["anchors"].tobytes().decode().split("\n"))
        self._number = {name: i for i, name in enumerate(self.known)}
        self._x = {name: np.asarray(arrays[name], np.float64) for name in ARRAYS if name not in ("anchors", "owners")}
        if odd := next((name for name, array in self._x.items() if not np.isfinite(array).all()), None):
            raise DataError(f"{LAST}: {odd} holds values that are not finite; train the head again")
        d = len(self._x["turn"])
        shapes = {
            "added": (len(self.known), d),
            "bias": (len(self.known),),
            "turn": (d, d),
            "silence": (d,),
            "ask": (d, d),
        }
        shapes |= {"silence_bias": (), "pair": (N_FEATURES,), "owner_pair": (N_FEATURES,)}
        if odd := next((name for name, shape in shapes.items() if self._x[name].shape != shape), None):
            raise DataError(f"{LAST}: {odd} {self._x[odd].shape}, expected {shapes[odd]}; train the head again")
        self._owners = tuple(arrays["owners"].tobytes().decode().split("\n"))
        self._wanted = self._names(self._owners) @ self._x["ask"]  # (T, D)
        self._anchor_rows = self._rows(self.known)  # (A, D)
        self._said: dict[str, Array] = {}
        self._told: dict[tuple[str, tuple[str, ...]], Array] = {}

    @classmethod
    def load(cls, folder: Path, pairs: PairReader, relations: EvidenceReader) -> SceneEvidence:
        """Load what a run left in ``folder``.

        Args:
            folder: with adapter and last layer.
            pairs: pair features.
            relations: reads relations.

        Raises:
            DataError: a file is missing, damaged, or of another kind.
        """
        arrays, sha256 = load_arrays(folder / LAST)
        encoder = StoredEncoder(AdaptedMiniLM(folder / ADAPTER))
        made_of = f"{sha256} {encoder.name} {getattr(relations, 'sha256', '')}"
        try:
            out = cls(arrays, sha256_bytes(made_of.encode()), encoder, pairs, relations)
        except (ValueError, TypeError, IndexError) as error:
            raise DataError(f"{folder / LAST}: does not fit ({str(error)[:80]}); train the head again") from None
        out.files = {name: read_verified(folder / name) for name in (ADAPTER, LAST)}
        return out

    def read(self, texts: Sequence[str]) -> Evidence:
        """Evidence of H texts. Unlike the habit book's reader, probabilities of a row need not add up to 1."""
        new = [text for text in dict.fromkeys(texts) if text not in self._said]
        if len(self._said) + len(new) > REMEMBERED:
            self._said.clear()
            new = list(dict.fromkeys(texts))
        self._said.update(zip(new, self.spoken(new, self.known), strict=True))
        anchor = np.stack([self._said[text] for text in texts]) if texts else np.zeros((0, len(self.known)))
        return Evidence(anchor, anchor.max(axis=1, initial=0.0), self._relations.read(texts).relation)

    def spoken(self, texts: Sequence[str], names: Sequence[str], features: NDArray[np.floating] | None = None) -> Array:
        """Probability (H, C) that each text speaks for each name.

        Args:
            texts: H sentences.
            names: C names.
            features: (H, C, 6) pair features, if they were computed before.
        """
        if not texts or not names:
            return np.zeros((len(texts), len(names)))
        if features is None:
            features = self.pairs.features(texts, names)
        vectors = self._vectors.encode_half(texts).astype(np.float64)
        met = [self._number.get(name, -1) for name in names]
        rows = self._anchor_rows if tuple(names) == self.known else self._rows(names)
        bias = np.asarray([self._x["bias"][k] if k >= 0 else 0.0 for k in met])
        silence = vectors @ self._x["silence"] + float(self._x["silence_bias"])
        score = SCALE * (vectors @ rows.T - silence[:, None]) + bias + features.astype(np.float64) @ self._x["pair"]
        return sigmoid(np.round(score, DECIMALS))

    def about(self, target: str, texts: Sequence[str]) -> Array:
        """(H,) log odds that each text is about the target and not about another category of the household.

        Args:
            target: category that is looked for.
            texts: H sentences.
        """
        if not texts:
            return np.zeros(0)
        asked = target, tuple(texts)
        if asked not in self._told:  # called again for every candidate that is added
            if len(self._told) >= _ASKED:
                self._told.clear()
            self._told[asked] = self._log_odds(texts, target)
        return self._told[asked]

    def _log_odds(self, texts: Sequence[str], target: str) -> Array:
        score = self._owned(texts, target)
        own, others = score[:, 0], score[:, 1:]
        most = others.max(axis=1)
        rest = most + np.log(np.exp(others - most[:, None]).sum(axis=1))
        return np.round(own - rest + np.log(others.shape[1] / _HOUSEHOLD), DECIMALS)

    def _owned(self, texts: Sequence[str], target: str) -> Array:
        """(H, T) scores of what texts may be about: the target in column 0, then the other known categories."""
        others = [k for k, name in enumerate(self._owners) if name != target]
        wanted = np.concatenate([self._names([target]) @ self._x["ask"], self._wanted[others]])
        features = self.pairs.features(texts, [target, *(self._owners[k] for k in others)]).astype(np.float64)
        vectors = self._vectors.encode_half(texts).astype(np.float64)
        return np.asarray(vectors @ wanted.T + features @ self._x["owner_pair"])

    def _rows(self, names: Sequence[str]) -> Array:
        """(C, D) vectors that sentences are compared with.

        The vector of a name, linearly mapped, plus a learned offset for known names.
        """
        out: Array = self._names(names) @ self._x["turn"]
        for i, name in enumerate(names):
            if name in self._number:
                out[i] += self._x["added"][self._number[name]]
        return out

    def _names(self, names: Sequence[str]) -> Array:
        return self.pairs.encoder.encode_half([phrase(name) for name in names]).astype(np.float64)
