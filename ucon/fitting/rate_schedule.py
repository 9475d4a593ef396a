"""The learning rate over a run: a rise, then half a cosine."""

from __future__ import annotations

import math


def schedule(step: int, steps: int, warm_up: int) -> float:
    """Share of the learning rate at ``step``: a linear rise, then half a cosine down to zero."""
    if step < warm_up:
        return (step + 1) / warm_up
    return 0.5 * (1 + math.cos(math.pi * (step - warm_up) / max(1, steps - warm_up)))
