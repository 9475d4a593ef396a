"""Weights of the anchor reader: one checked file of named arrays, and the small network steps that use them.

Everything runs in float64 on numpy and is rounded to 1e-4 where texts meet weights, so results do not depend on
which texts are read together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.core.files import read_verified, sha256_bytes
from ucon.core.untrusted.unpack import MAX_BYTES, UnpackError, read_arrays

WEIGHTS = Path(__file__).parent / "data" / "reader.npz"
Array = NDArray[np.float64]
EVIDENCE = ("anchors", "vocabulary", "bow", "dense", "pair", "bias", "any")
"""What the evidence reader needs."""
REQUIRED = (
    *EVIDENCE,
    "prior_dense",
    "prior_bias",
    "relation_prior",
    "gate_habit",
    "gate_target",
    "gate_hidden",
    "gate_hidden_bias",
    "gate_out",
    "mix_hidden",
    "mix_hidden_bias",
    "mix_out",
)


class ReaderWeights:
    """Named float64 arrays, two lists of names, and the hash of the file."""

    def __init__(
        self,
        arrays: Mapping[str, NDArray],
        sha256: str,
        required: Sequence[str] = REQUIRED,
        made_by: str = "python -m ucon data fit-reader",
    ) -> None:
        missing = [name for name in required if name not in arrays]
        if missing:
            raise DataError(f"reader weights: no {', '.join(missing)}; make them with `{made_by}`")
        self.sha256 = sha256
        self.anchors: tuple[str, ...] = tuple(_names(arrays["anchors"]))
        """Anchor categories that the reader has met in training, sorted."""
        self.vocabulary: dict[str, int] = {word: i for i, word in enumerate(_names(arrays["vocabulary"]))}
        self._arrays = {k: np.asarray(v, np.float64) for k, v in arrays.items() if v.dtype.kind == "f" and k != "bow"}
        self.bow: NDArray[np.float32] = arrays["bow"].astype(np.float32)
        """(V, A + 5): a row a word or word pair; columns are the anchors, "no place", and the four relations."""

    def __getitem__(self, name: str) -> Array:
        return self._arrays[name]


def pack_names(names: list[str] | tuple[str, ...]) -> NDArray[np.uint8]:
    """Names as bytes, one a line: arrays without pickle."""
    return np.frombuffer("\n".join(names).encode(), np.uint8)


def _names(packed: NDArray) -> list[str]:
    return packed.tobytes().decode().split("\n")


def load_weights(path: Path, required: Sequence[str] = REQUIRED) -> ReaderWeights:
    """Weights of a file that its folder's manifest lists; ``required`` arrays must be there."""
    return ReaderWeights(*load_arrays(path), required=required)


def load_arrays(path: Path) -> tuple[dict[str, NDArray], str]:
    """Named arrays of a file that its folder's manifest lists, and the file's hash.

    Raises:
        DataError: the file is missing, altered, or holds no arrays.
    """
    raw = read_verified(path)
    try:
        return read_arrays(raw, MAX_BYTES), sha256_bytes(raw)
    except UnpackError as error:
        raise DataError(f"{path}: not a file of arrays ({error}); restore it from the release") from None


@cache
def default_weights() -> ReaderWeights:
    """The shipped weights."""
    return load_weights(WEIGHTS)


def softmax(logits: Array) -> Array:
    """Softmax over the last axis."""
    e = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return e / e.sum(axis=-1, keepdims=True)


def sigmoid(x: Array) -> Array:
    """Logistic function."""
    return 1 / (1 + np.exp(-np.clip(x, -40, 40)))


def two_layers(x: Array, hidden: Array, bias: Array, out: Array) -> Array:
    """Tanh network (..., n) -> (...,): ``hidden`` (n, k), ``bias`` (k,), ``out`` (k + n + 1,) with a linear path."""
    k = len(bias)
    return np.tanh(x @ hidden + bias) @ out[:k] + x @ out[k:-1] + out[-1]
