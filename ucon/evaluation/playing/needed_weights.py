"""Weights that an agent and a detector need: whether they are there, and which they are.

An agent or detector may offer ``check()``, which raises an error of one line, and ``fingerprint()``, which says which
weights lie here: "" where it needs none, None where they are missing.
"""

from __future__ import annotations

from typing import Any


def check_weights(*parts: Any) -> None:
    """Fail in one line, before anything is played, where a language model's or detector's weights are missing."""
    for part in parts:
        check = getattr(part, "check", None)
        if check is not None:
            check()


def fingerprints(*parts: Any) -> tuple[str, ...] | None:
    """Fingerprints of all weights on this machine; None where some are missing, so that nothing can be said."""
    found = [part.fingerprint() for part in parts if hasattr(part, "fingerprint")]
    return None if None in found else tuple(made for made in found if made)
