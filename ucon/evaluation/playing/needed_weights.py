"""Weights that agents and detectors need: whether they are present, and their fingerprints.

A part may have ``check()``, which raises a one-line error, and ``fingerprint()``, which gives a hash of the weights: ""
where it needs none, None where they are missing.
"""

from __future__ import annotations

from typing import Any


def check_weights(*parts: Any) -> None:
    """Raise a one-line error, before anything is played, where weights of one of the parts are missing."""
    for part in parts:
        check = getattr(part, "check", None)
        if check is not None:
            check()


def fingerprints(*parts: Any) -> tuple[str, ...] | None:
    """Fingerprints of all parts' weights; None where some are missing."""
    found = [part.fingerprint() for part in parts if hasattr(part, "fingerprint")]
    return None if None in found else tuple(made for made in found if made)
