"""Checksums of trained weights, by which results and training runs identify the weights they used."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class Fingerprinted(Protocol):
    """An object with weights that are not part of its configuration."""

    def fingerprint(self) -> str | None:
        """Checksum of the weights; "" if it has none, None if they are missing."""
        ...


def fingerprint_of(part: object) -> str | None:
    """The fingerprint of an object; "" if it has none."""
    return part.fingerprint() if isinstance(part, Fingerprinted) else ""
