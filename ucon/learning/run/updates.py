"""Updates of parameters: AdamW with clipped gradients, a moving average, and a check for divergence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import torch
from torch import Tensor, nn

from ucon.core.errors import ConfigError, DataError, DivergedError, unknown_name
from ucon.learning.run.moving_average import MovingAverage
from ucon.learning.run.protocol import Figures

_MOMENTS = ("exp_avg", "exp_avg_sq", "step")
#: Form of the optimiser's step count (a scalar float32), and an upper bound for it.
_STEP, _MOST_STEPS = torch.zeros(()), 1 << 40


class Updates:
    """Optimiser of parameters: gradient clipping, AdamW, schedule and moving average.

    Args:
        learned: a module, whose trainable parameters are updated and whose buffers are stored with them; or parameters
            by name.
        lr: highest learning rate.
        clip: largest norm of the whole gradient; a larger one is scaled down to it.
        steps: length of the schedule: a linear rise over ``warm_up`` steps, then half a cosine down to a tenth; 0 for a
            constant rate after the rise.
        warm_up: steps until the highest rate is reached.
        decay: weight decay (decoupled).
        average: decay of the moving average; 0 follows the parameters.
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
        """Number of updates so far; one step of a learner may make many."""

    def begin(self) -> None:
        """Clear the gradients before a backward pass."""
        self._optimiser.zero_grad(set_to_none=True)

    def take(self, step: int, rate: float | None = None) -> Figures:
        """Clip the accumulated gradient, update the parameters and the moving average.

        Args:
            step: number of the learner's step, from 0; it decides the learning rate.
            rate: learning rate to use instead of the schedule's.

        Returns:
            ``gradient`` (norm before clipping) and ``rate``.

        Raises:
            DivergedError: a gradient that is not finite; names the first such parameter.
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
        """Stretch the schedule to ``steps`` steps from now on; False where the rate is constant."""
        if not self.steps:
            return False
        self.steps = steps
        return True

    @property
    def average(self) -> Mapping[str, Tensor]:
        """Moving average of the parameters by name; shapes and dtypes of the parameters."""
        return self._average.values

    @contextmanager
    def averaged(self) -> Iterator[None]:
        """Context manager: the parameters hold their moving average inside it."""
        with self._average.in_place():
            yield

    def tensors(self) -> dict[str, Tensor]:
        """State to be stored: parameters and buffers (``learned/``), average (``average/``) and Adam's moments.

        The number of the learner's steps is not in it.
        """
        found = {f"learned/{name}": value.detach() for name, value in self._held().items()}
        found |= {f"average/{name}": value for name, value in self._average.values.items()}
        for name, value in self.parameters.items():
            moments = self._optimiser.state.get(value, {})
            found |= {f"{kind}/{name}": moments[kind] for kind in _MOMENTS if kind in moments}
        return found

    def load(self, tensors: Mapping[str, Tensor], done: int) -> None:
        """Restore a state of :meth:`tensors`.

        Args:
            tensors: on the CPU, by name; not trusted.
            done: steps of the learner; 0 means that there are no moments yet.

        Raises:
            DataError: names, shapes or dtypes of another network, or impossible values.
        """
        wanted = {f"learned/{name}": value for name, value in self._held().items()}
        wanted |= {f"average/{name}": value for name, value in self.parameters.items()}
        for kind in _MOMENTS if done else ():  # a parameter without a gradient so far has no moments
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
        """Parameters, and the buffers of a module, by name; references, so they can be read and written in place."""
        return self._learned.state_dict() if isinstance(self._learned, nn.Module) else self._learned

    def _rate(self, step: int) -> float:
        """Learning rate of step number ``step``, from 0."""
        if step < self.warm_up:
            return self.lr * (step + 1) / self.warm_up
        if not self.steps:
            return self.lr
        done = min(1.0, (step - self.warm_up) / max(1, self.steps - self.warm_up))
        share = 0.5 * (1 + math.cos(math.pi * done))
        return self.lr * (0.1 + 0.9 * share)


def learn_only(module: nn.Module, names: Sequence[str]) -> None:
    """Leave only some parameters of a module trainable.

    Args:
        module: whose other parameters are frozen.
        names: of parameters, or of modules that hold them.

    Raises:
        ConfigError: a name that no parameter has or begins with.
    """
    held = {name: set(_prefixes(name)) for name, _ in module.named_parameters()}
    known = set().union(*held.values())
    for wanted in map(str, names):
        if wanted not in known:
            shown = (name for name in known if name.count(".") < 2)
            raise ConfigError(f"learner.only: {unknown_name('parameter or module', wanted, shown)}")
    for name, value in module.named_parameters():
        value.requires_grad_(value.requires_grad and not held[name].isdisjoint(names))


def _prefixes(name: str) -> Iterator[str]:
    """Names of a parameter and of all modules that hold it."""
    while name:
        yield name
        name = name.rpartition(".")[0]


def _require_sound(tensors: Mapping[str, Tensor]) -> None:
    """Refuse values that no optimiser leaves: not finite, or a negative second moment or step count.

    Raises:
        DataError: naming the first tensor with such a value.
    """
    for name, value in tensors.items():
        least, most = (0.0, _MOST_STEPS) if name.startswith("step/") else (-torch.inf, torch.inf)
        least = 0.0 if name.startswith("exp_avg_sq/") else least
        if value.is_floating_point() and not bool((torch.isfinite(value) & (value >= least) & (value <= most)).all()):
            raise DataError(f"state with invalid values in {name}")


def require_finite(tensors: Mapping[str, Tensor], step: int) -> None:
    """Refuse tensors with NaN or infinity.

    Args:
        tensors: by the name that the message gives.
        step: number of the step, from 0.

    Raises:
        DivergedError: naming the first such tensor and how many of its values are not finite.
    """
    for name, value in tensors.items():
        if value.is_floating_point() and not bool(torch.isfinite(value).all()):
            bad = int((~torch.isfinite(value)).sum())
            raise DivergedError(
                f"step {step + 1}: {name} is not finite ({bad} of {value.numel()}); "
                "start a new run with a smaller learner.lr"
            )
