"""Weights of the anchor reader: a checked file of named arrays, and the small functions that apply them.

Computed in float64 and rounded to 1e-4 where texts meet weights, so results do not depend on which texts are read
together.
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
"""Arrays that the evidence reader needs."""
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
    """Named float64 arrays, two lists of names, and the hash of the file.

    Args:
        arrays: by name.
        sha256: hash of the file.
        required: names that must be there.
        made_by: command that makes the file, for the error.

    Raises:
        DataError: an array is missing.
    """

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
        self.anchors: tuple[str, ...] = tuple(unpacked_names(arrays["anchors"]))
        """Anchor categories in the training data, sorted."""
        self.vocabulary: dict[str, int] = {word: i for i, word in enumerate(unpacked_names(arrays["vocabulary"]))}
        self._arrays = {k: np.asarray(v, np.float64) for k, v in arrays.items() if v.dtype.kind == "f" and k != "bow"}
        self.bow: NDArray[np.float32] = arrays["bow"].astype(np.float32)
        """(V, A + 5), a row per word or word pair; columns are the anchors, "no place" and the four relations."""

    def __getitem__(self, name: str) -> Array:
        return self._arrays[name]


def pack_names(names: list[str] | tuple[str, ...]) -> NDArray[np.uint8]:
    """Names as bytes, one per line, so that npz files need no pickle."""
    return np.frombuffer("\n".join(names).encode(), np.uint8)


def unpacked_names(packed: NDArray) -> list[str]:
    """The names that :func:`pack_names` packed."""
    return packed.tobytes().decode().split("\n")


def load_weights(path: Path, required: Sequence[str] = REQUIRED) -> ReaderWeights:
    """Read weights from a file that its folder's manifest lists.

    Args:
        path: npz file.
        required: names of arrays that must be there.

    Raises:
        DataError: the file is missing or altered, or lacks an array.
    """
    return ReaderWeights(*load_arrays(path), required=required)


def load_arrays(path: Path) -> tuple[dict[str, NDArray], str]:
    """Read named arrays from a file that its folder's manifest lists.

    Args:
        path: npz file.

    Returns:
        Arrays by name, and the SHA-256 of the file.

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
    """The shipped weights, read once per process."""
    return load_weights(WEIGHTS)


def softmax(logits: Array) -> Array:
    """Softmax over the last axis."""
    e = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return e / e.sum(axis=-1, keepdims=True)


def sigmoid(x: Array) -> Array:
    """Logistic function; arguments are clipped to [-40, 40]."""
    return 1 / (1 + np.exp(-np.clip(x, -40, 40)))


def two_layers(x: Array, hidden: Array, bias: Array, out: Array) -> Array:
    """Network with one tanh layer and a parallel linear path, (..., n) -> (...,).

    Args:
        x: (..., n) inputs.
        hidden: (n, k) weights.
        bias: (k,).
        out: (k + n + 1,) weights of the hidden units, of the inputs, and a bias.
    """
    k = len(bias)
    return np.tanh(x @ hidden + bias) @ out[:k] + x @ out[k:-1] + out[-1]
