"""Updates of a network: Adam with clipped gradients, a moving average, a stop where numbers are none, and its state."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import torch
from torch import Tensor, nn

from ucon.core.errors import DataError, DivergedError
from ucon.learning.run.moving_average import MovingAverage
from ucon.learning.run.protocol import Figures

_MOMENTS = ("exp_avg", "exp_avg_sq", "step")
#: As the optimiser counts, and far more than it ever will.
_STEP, _MOST_STEPS = torch.zeros(()), 1 << 40


class Updates:
    """Changes parameters, one gradient after the other.

    Args:
        learned: a module, whose parameters that ask for gradients are learned and whose buffers are kept with them;
            or parameters by name.
        lr: highest learning rate of Adam.
        clip: norm to which gradients are cut.
        steps: length of the schedule: a rise over ``warm_up`` steps, then half a cosine down to a tenth; 0 holds it.
        warm_up: steps until the highest rate is reached.
        decay: weight decay (decoupled).
        average: share of the moving average that one update keeps; 0 follows the parameters.
    """

    def __init__(
        self,
        learned: nn.Module | Mapping[str, Tensor],
        *,
        lr: float,
        clip: float = 1.0,
        steps: int = 0,
        warm_up: int = 0,
        decay: float = 0.0,
        average: float = 0.0,
    ) -> None:
        self.lr, self.clip, self.steps, self.warm_up = lr, clip, steps, warm_up
        self._learned = learned
        named = learned.named_parameters() if isinstance(learned, nn.Module) else learned.items()
        self.parameters = {name: value for name, value in named if value.requires_grad}
        self._optimiser = torch.optim.AdamW(self.parameters.values(), lr=lr, weight_decay=decay)
        self._average = MovingAverage(self.parameters, average)
        self.taken = 0
        """Updates so far: a step may make many."""

    def begin(self) -> None:
        """Forget the gradient of the last step."""
        self._optimiser.zero_grad(set_to_none=True)

    def take(self, step: int, rate: float | None = None) -> Figures:
        """Update along the gradient that was collected, at the rate of step number ``step``, from 0, or at ``rate``.

        Raises:
            DivergedError: a gradient that is not finite; names the first of them.
        """
        rate = self._rate(step) if rate is None else rate
        for group in self._optimiser.param_groups:
            group["lr"] = rate
        gradients = {f"gradient of {n}": p.grad for n, p in self.parameters.items() if p.grad is not None}
        norm = torch.nn.utils.get_total_norm(gradients.values())
        if not bool(torch.isfinite(norm)):  # before clipping, which would spread it to all of them
            require_finite(gradients, step)
        torch.nn.utils.clip_grads_with_norm_(self.parameters.values(), self.clip, norm)
        self._optimiser.step()
        self._average.update(self.taken)
        self.taken += 1
        return {"gradient": float(norm), "rate": rate}

    def lengthen(self, steps: int) -> bool:
        """Follow the schedule of so many steps from now on; False where there is none."""
        if not self.steps:
            return False
        self.steps = steps
        return True

    @property
    def average(self) -> Mapping[str, Tensor]:
        """The moving average of the parameters by name."""
        return self._average.values

    @contextmanager
    def averaged(self) -> Iterator[None]:
        """The parameters are their average inside."""
        with self._average.in_place():
            yield

    def tensors(self) -> dict[str, Tensor]:
        """Everything that decides how it goes on but the number of steps."""
        found = {f"learned/{name}": value.detach() for name, value in self._held().items()}
        found |= {f"average/{name}": value for name, value in self._average.values.items()}
        for name, value in self.parameters.items():
            moments = self._optimiser.state.get(value, {})
            found |= {f"{kind}/{name}": moments[kind] for kind in _MOMENTS if kind in moments}
        return found

    def load(self, tensors: Mapping[str, Tensor], done: int) -> None:
        """Go on from :meth:`tensors` after ``done`` steps.

        Raises:
            DataError: tensors of another network.
        """
        wanted = {f"learned/{name}": value for name, value in self._held().items()}
        wanted |= {f"average/{name}": value for name, value in self.parameters.items()}
        for kind in _MOMENTS if done else ():  # a parameter that had no gradient yet has none
            had = [name for name in self.parameters if f"{kind}/{name}" in tensors]
            wanted |= {f"{kind}/{n}": _STEP if kind == "step" else self.parameters[n] for n in had}
        if {name: (v.shape, v.dtype) for name, v in tensors.items()} != {
            n: (v.shape, v.dtype) for n, v in wanted.items()
        }:
            raise DataError("state of another learner: names or shapes differ; resume with the run's own configuration")
        _require_sound(tensors)
        with torch.no_grad():
            for name, value in self._held().items():
                value.copy_(tensors[f"learned/{name}"])
        self._optimiser.state.clear()
        self.taken = max((int(value) for name, value in tensors.items() if name.startswith("step/")), default=0)
        for name, value in self.parameters.items():
            self._average.values[name].copy_(tensors[f"average/{name}"])
            if f"step/{name}" in tensors:
                moments = {kind: tensors[f"{kind}/{name}"].clone().to(value.device) for kind in _MOMENTS[:2]}
                self._optimiser.state[value] = {"step": tensors[f"step/{name}"].clone(), **moments}

    def _held(self) -> Mapping[str, Tensor]:
        """Parameters, and the buffers of a module: to be read, and written in place."""
        return self._learned.state_dict() if isinstance(self._learned, nn.Module) else self._learned

    def _rate(self, step: int) -> float:
        if step < self.warm_up:
            return self.lr * (step + 1) / self.warm_up
        if not self.steps:
            return self.lr
        done = min(1.0, (step - self.warm_up) / max(1, self.steps - self.warm_up))
        share = 0.5 * (1 + math.cos(math.pi * done))
        return self.lr * (0.1 + 0.9 * share)


def _kinds(tensors: Mapping[str, Tensor]) -> dict[str, tuple[torch.Size, torch.dtype]]:
    return {name: (value.shape, value.dtype) for name, value in tensors.items()}


def _require_sound(tensors: Mapping[str, Tensor]) -> None:
    """Refuse a state that no optimiser leaves.

    Raises:
        DataError: names the first tensor with a value that cannot be.
    """
    for name, value in tensors.items():
        least, most = (0.0, _MOST_STEPS) if name.startswith("step/") else (-torch.inf, torch.inf)
        least = 0.0 if name.startswith("exp_avg_sq/") else least
        if value.is_floating_point() and not bool((torch.isfinite(value) & (value >= least) & (value <= most)).all()):
            raise DataError(f"state with {name}, which holds values that cannot be; go on from an earlier checkpoint")


def require_finite(tensors: Mapping[str, Tensor], step: int) -> None:
    """Refuse numbers that are none.

    Raises:
        DivergedError: names the first tensor with one.
    """
    for name, value in tensors.items():
        if value.is_floating_point() and not bool(torch.isfinite(value).all()):
            bad = int((~torch.isfinite(value)).sum())
            raise DivergedError(
                f"step {step + 1}: {name} is not finite ({bad} of {value.numel()}); "
                "start a run anew with a smaller learner.lr"
            )
