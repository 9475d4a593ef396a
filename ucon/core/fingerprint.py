"""Which trained weights something has, by hash: results and runs of training say whose they are by it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class Fingerprinted(Protocol):
    """Has weights that are not in its configuration."""

    def fingerprint(self) -> str | None:
        """Hash of the weights; "" without any, None where they are missing."""
        ...


def fingerprint_of(part: object) -> str | None:
    """The fingerprint of a part; "" of one that has none."""
    return part.fingerprint() if isinstance(part, Fingerprinted) else ""
