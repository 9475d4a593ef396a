"""Fitting a few parameters by maximum likelihood: a loss in torch, minimised within bounds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bounds = Sequence[tuple[float, float]]


def minimised(
    loss: Callable[[Any], Any], start: NDArray[np.float64], bounds: Bounds, steps: int
) -> NDArray[np.float64]:
    """Parameters with the least loss, by L-BFGS-B.

    Args:
        loss: maps a float32 tensor (n,) to a scalar tensor.
        start: (n,) initial values.
        bounds: lower and upper bound of each.
        steps: most iterations.

    Returns:
        (n,) float64.
    """
    import torch
    from scipy.optimize import minimize

    def value_and_slope(values: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        x = torch.tensor(values, dtype=torch.float32, requires_grad=True)
        value = loss(x)
        value.backward()
        assert x.grad is not None
        return value.item(), x.grad.numpy().astype(np.float64)

    found = minimize(value_and_slope, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": steps})
    return np.asarray(found.x, np.float64)
