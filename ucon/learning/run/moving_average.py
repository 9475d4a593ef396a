"""A moving average of parameters: what many small steps agree on, used in place of where the last one ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import torch
from torch import Tensor


class MovingAverage:
    """Averages parameters over their last steps.

    Args:
        parameters: by name; changed in place by an optimiser.
        decay: share of the average that one step keeps, 0 <= decay < 1; 0 follows the parameters. Smaller in the
            first steps, so that the start is soon forgotten.
    """

    def __init__(self, parameters: Mapping[str, Tensor], decay: float) -> None:
        self._parameters, self.decay = parameters, decay
        self.values = {name: value.detach().clone() for name, value in parameters.items()}
        """The average by name; shapes and dtypes of the parameters."""

    @torch.no_grad()
    def update(self, step: int) -> None:
        """Take in the parameters after update number ``step``, from 0."""
        keep = min(self.decay, (1 + step) / (10 + step))
        for name, value in self._parameters.items():
            self.values[name].lerp_(value, 1 - keep)

    @contextmanager
    def in_place(self) -> Iterator[None]:
        """The parameters are the average inside, and themselves again afterwards."""
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
