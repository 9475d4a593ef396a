"""``learner=judge``: trains the judge of suspects on hypotheses of searches in training homes.

The hypotheses are those of searches by belief with detectors of several strengths, at mixed habit levels
(:mod:`ucon.learning.judge.cases`). A step depends only on seed and number, so a resumed run repeats an uninterrupted
one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import save
from torch import Tensor, nn
from torch.nn.functional import binary_cross_entropy_with_logits

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_file
from ucon.core.rng import derived_seed, stream
from ucon.core.tensor_files import read_fitting
from ucon.fitting.rate_schedule import schedule
from ucon.fitting.suspect_cases import SuspectCases
from ucon.learning.judge.cases import case_hash, collected
from ucon.learning.run.counted_steps import CountedSteps
from ucon.learning.run.options import JudgeOptions
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.run_folder import MODEL
from ucon.learning.run.updates import Updates
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.readers.belief_scores import calibration_error
from ucon.search.suspects import EVIDENCE, arithmetic

WEIGHTS = "judge.safetensors"
CONFIG = "config.json"
#: Looks from different sides, whatever names the detector gave, from which on a suspect counts in ``auroc_2``.
INDEPENDENT = 2


class JudgeLearner(CountedSteps):
    """Trains the judge (see the module).

    Args:
        judge: makes the network (:class:`models.nets.judge.JudgeNet`).
        detectors: detectors of the searches, by name; each has its errors.
        options: fields of :class:`ucon.learning.run.options.JudgeOptions`.

    Raises:
        ConfigError: a value out of range, or no detectors.
        DataError: ``initial`` holds no judge, a damaged one, or one of other sizes.
    """

    options_of = JudgeOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(self, judge: Callable[[], nn.Module], detectors: Mapping[str, BoxDetector], **options: Any) -> None:
        self.options = given = JudgeOptions(**options)
        if not detectors:
            raise ConfigError("learner.detectors={}: expected at least one detector")
        self.steps, self._detectors = given.steps, tuple(detectors.values())
        torch.manual_seed(derived_seed(given.seed, "judge"))
        self.net = judge()
        self._initial = "" if given.initial is None else self._begin_with(Path(given.initial).expanduser())
        self.updates = Updates(self.net, lr=given.lr, decay=given.decay, average=given.average)

    @property
    def identity(self) -> Mapping[str, str]:
        """Hash of what decides the training data and, if given, of the initial weights."""
        initial = {"initial": self._initial} if self._initial else {}
        cases = f"{case_hash(self.options.episodes, self._detectors, 0)} {self.options.searches}"
        return {"cases": cases, **initial}

    def _begin_with(self, folder: Path) -> str:
        """Load the weights of another judge; returns the SHA-256 of their file."""
        path = (folder / MODEL if (folder / MODEL).is_dir() else folder) / WEIGHTS
        self.net.load_state_dict(read_fitting(path, self.net.state_dict())[0])
        return sha256_file(path)

    @cached_property
    def cases(self) -> SuspectCases:
        """Training cases; collected at first use, which takes most of the time."""
        found = self._cases(self.options.episodes, self.options.searches)
        if self._initial:  # the initial weights have their own scale
            return found
        mean, scale = found.evidence.mean(0), found.evidence.std(0)
        self.net.mean.copy_(torch.from_numpy(mean))  # type: ignore[operator, union-attr]
        self.net.scale.copy_(torch.from_numpy(np.maximum(scale, 1e-3)))  # type: ignore[operator, union-attr]
        return found

    @cached_property
    def validation(self) -> SuspectCases:
        """Cases of homes that are not trained on."""
        return self._cases(self.options.validation, self.options.validation_searches)

    def _cases(self, episodes: str, searches: int) -> SuspectCases:
        return collected(episodes, searches, self._detectors, 0, self.options.workers)

    def step(self) -> Figures:
        """Update the judge on one batch of cases.

        Returns:
            ``loss``, with ``gradient`` and ``rate``.
        """
        cases = self.cases
        rows = stream(self.options.seed, "judge", self._done).integers(len(cases.home), size=self.options.batch)
        self.net.train()
        self.updates.begin()
        loss = binary_cross_entropy_with_logits(
            self.net(torch.from_numpy(cases.evidence[rows])),
            torch.from_numpy(cases.is_target[rows].astype(np.float32)),
            torch.from_numpy(cases.weight[rows]),
        )
        loss.backward()  # type: ignore[no-untyped-call]
        rate = self.options.lr * schedule(self._done, self.steps, self.options.warm_up)
        updated = self.updates.take(self._done, rate)
        self._done += 1
        return {"loss": float(loss.detach()), **updated}

    def validate(self) -> Figures:
        """Figures of the averaged judge in homes that it was not trained on, and of the arithmetic posterior.

        ``nll`` (nats a suspect), ``ece``, ``auroc`` of suspects, ``auroc_2`` of those found from two sides or more;
        ``score`` is minus ``nll``.
        """
        suspects = self.validation.keep(self.validation.weight == 1.0)
        _ = self.cases  # for the scale of the evidence
        with self.updates.averaged(), torch.no_grad():
            self.net.eval()
            p = torch.sigmoid(self.net(torch.from_numpy(suspects.evidence)).double()).numpy()
        found = measures(p, suspects)
        plain = {
            f"arithmetic/{name}": value for name, value in measures(arithmetic(suspects.evidence), suspects).items()
        }
        return {**found, **plain, "suspects": float(len(p)), "score": -found["nll"]}

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all; always True."""
        self.steps = steps
        return True

    def product(self) -> Mapping[str, bytes]:
        """Files of the trained judge: averaged weights and the scale of the evidence, and its options as JSON."""
        _ = self.cases
        tensors: dict[str, Tensor] = {name: value.clone() for name, value in self.net.state_dict().items()}
        tensors |= {name: value.detach().clone() for name, value in self.updates.average.items()}
        options = {**self.net.options, "evidence": list(EVIDENCE)}  # type: ignore[dict-item]
        return {
            WEIGHTS: save({name: value.contiguous() for name, value in tensors.items()}),
            CONFIG: (json.dumps(options, indent=1, sort_keys=True) + "\n").encode(),
        }

    def close(self) -> None:
        """Nothing to close: worker processes end with the collection."""

    def card(self) -> Card:
        """Text of the model card: inputs, outputs, training data and limits."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        names = ", ".join(f"`{d.name}`" for d in self._detectors)
        cases = self.cases
        return Card(
            "Judge: is this thing on the map the target?",
            f"A network of {size:,} parameters. It corrects the arithmetic posterior of a suspect by {len(EVIDENCE)} "
            "numbers: looks and scores, looks in vain, size, neighbours, and what the habits expect in that place.\n\n"
            f"Trained on {len(cases.home):,} hypotheses ({int(cases.is_target.sum()):,} of the target) of "
            f"{self.options.searches:,} searches in `{self.options.episodes}` homes with the detectors {names}, at "
            "habit levels none, retrieval, full and gt.\n\n"
            "It knows the errors of simulated detectors. With a real one, fit its errors first "
            "(`python -m ucon detector fit`); how well the judge is calibrated there was not measured.",
        )


def measures(p: NDArray[np.float64], suspects: SuspectCases) -> Figures:
    """How good probabilities of suspects are.

    Args:
        p: (n,) probabilities.
        suspects: n cases.

    Returns:
        ``nll``, ``ece``, ``auroc`` and ``auroc_2``; see :meth:`JudgeLearner.validate`.
    """
    true = suspects.is_target
    kept = np.clip(p, 1e-6, 1.0 - 1e-6)
    nll = -np.where(true, np.log(kept), np.log1p(-kept)).mean()
    called = np.expm1(suspects.evidence[:, EVIDENCE.index("called")]) + np.expm1(
        suspects.evidence[:, EVIDENCE.index("called_else")]
    )
    often = called >= INDEPENDENT - 0.5
    return {
        "nll": round(float(nll), 5),
        "ece": round(calibration_error(p, true.astype(float)), 4),
        "auroc": round(auroc(p, true), 4),
        "auroc_2": round(auroc(p[often], true[often]), 4),
    }


def auroc(score: NDArray[np.float64], true: NDArray[np.bool_]) -> float:
    """Probability that a true case scores higher than a false one; ties count half. 0.5 where there are none."""
    n, m = int(true.sum()), int((~true).sum())
    if not n or not m:
        return 0.5
    _, inverse, counts = np.unique(score, return_inverse=True, return_counts=True)
    rank = (np.cumsum(counts) - (counts - 1) / 2.0)[inverse]
    return float((rank[true].sum() - n * (n + 1) / 2.0) / (n * m))
