"""Exponential moving average of parameters, which is validated and kept in place of the last step's parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import torch
from torch import Tensor


class MovingAverage:
    """Exponential moving average of parameters over updates.

    Args:
        parameters: tensors by name; an optimiser changes them in place.
        decay: share of the average that one update keeps, 0 <= decay < 1; 0 follows the parameters. In the first
            updates it is smaller, (1 + n) / (10 + n), so that the initial weights are soon forgotten.
    """

    def __init__(self, parameters: Mapping[str, Tensor], decay: float) -> None:
        self._parameters, self.decay = parameters, decay
        self.values = {name: value.detach().clone() for name, value in parameters.items()}
        """The average by name; shapes, dtypes and devices of the parameters."""

    @torch.no_grad()
    def update(self, step: int) -> None:
        """Add the present parameters to the average after update number ``step``, counted from 0."""
        keep = min(self.decay, (1 + step) / (10 + step))
        for name, value in self._parameters.items():
            self.values[name].lerp_(value, 1 - keep)

    @contextmanager
    def in_place(self) -> Iterator[None]:
        """Context manager: the parameters hold the average inside it, and their own values again afterwards."""
        own = {name: value.detach().clone() for name, value in self._parameters.items()}
        self._set(self.values)
        try:
            yield
        finally:
            self._set(own)

    @torch.no_grad()
    def _set(self, values: Mapping[str, Tensor]) -> None:
        for name, value in self._parameters.items():
            value.copy_(values[name])
