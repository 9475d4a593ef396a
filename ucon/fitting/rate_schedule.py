"""Learning-rate schedule: linear warm-up, then half a cosine down to zero."""

from __future__ import annotations

import math


def schedule(step: int, steps: int, warm_up: int) -> float:
    """Factor of the learning rate at a step.

    Args:
        step: from 0.
        steps: length of the run.
        warm_up: steps of the linear rise.
    """
    if step < warm_up:
        return (step + 1) / warm_up
    return 0.5 * (1 + math.cos(math.pi * (step - warm_up) / max(1, steps - warm_up)))
