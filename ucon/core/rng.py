"""Random streams keyed by (seed, stage, name): an added item does not change the numbers of others."""

from __future__ import annotations

import hashlib

import numpy as np

from ucon.core.errors import ConfigError, brief


def stream(seed: int, *keys: str | int) -> np.random.Generator:
    """A random generator that depends on ``seed`` and ``keys`` alone.

    Philox keyed by SHA-256, so it is the same in every process and on every platform.

    Args:
        seed: any integer.
        *keys: strings and integers; ``"1"`` and ``1`` differ.

    Raises:
        ConfigError: the seed is not a whole number.

    Example:
        ``stream(7, "furnish", "kitchen_0", "fridge")``
    """
    return np.random.Generator(np.random.Philox(key=_key(seed, keys)))


def derived_seed(seed: int, *keys: str | int) -> int:
    """A 63-bit seed for code that needs an integer, keyed like :func:`stream`."""
    return _key(seed, keys) & ((1 << 63) - 1)


def _key(seed: int, keys: tuple[str | int, ...]) -> int:
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool):
        raise ConfigError(f"seed={brief(seed)}: must be a whole number")
    text = "\x1f".join([str(int(seed)), *(f"{type(k).__name__}:{k}" for k in keys)])
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "little")
