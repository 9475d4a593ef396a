"""``learner=belief``: trains the belief head to predict where things are kept, at all habit levels at once.

The fitted parts that read sentences for the head were fitted on the habit book's train text too. So each training
household is read by parts fitted on other categories (:mod:`ucon.learning.belief_head.crossfit`). In use, on the val
part and on other datasets, the head works with the shipped parts. A dataset bound to scenes has its own prior, fitted
on pairs that are not asked about. A step depends only on seed and number, so a resumed run repeats an uninterrupted
one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import save
from torch import Tensor, nn

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_file
from ucon.core.progress import ticked
from ucon.core.rng import derived_seed, stream
from ucon.core.tensor_files import read_fitting
from ucon.fitting.rate_schedule import schedule
from ucon.habits.splits import Split, entry_parts
from ucon.habits.types import HabitDataset
from ucon.learning.belief_head.draws import Draw, Draws, Sample, sample
from ucon.learning.belief_head.held_out_readers import Fold, folds_of, parts_of
from ucon.learning.belief_head.households import KnowledgeBases
from ucon.learning.belief_head.losses import losses
from ucon.learning.run.counted_steps import CountedSteps
from ucon.learning.run.options import BeliefOptions
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.run_folder import MODEL
from ucon.learning.run.updates import Updates
from ucon.readers.belief_scores import best_of, calibration_error, scores
from ucon.readers.household import FittedParts
from ucon.retrieval.levels import FIXED_LEVELS

WEIGHTS = "belief_head.safetensors"
CONFIG = "config.json"
#: File of the prior of a dataset that has its own.
PRIOR = "prior.npz"
#: First seeds of the knowledge bases of validation, and of those that the temperature is fitted on.
_CHOOSE, _CALIBRATE = 0, 5_000


class BeliefLearner(CountedSteps):
    """Trains the belief head on drawn households (see the module).

    Args:
        head: makes the network (:class:`models.nets.belief.belief_head.BeliefHead`), which reads
            :class:`~ucon.readers.head_inputs.HeadInputs`.
        dataset: habits; entries of ``train`` are trained on, entries of ``val`` choose the checkpoint and the
            temperature.
        draw: how training samples are drawn.
        parts: fitted parts that read the val part, and that the head is used with; by default those of
            :func:`~ucon.learning.belief_head.held_out_readers.parts_of`.
        folds: pieces of the train part with the parts that read them; fitted if not given.
        options: fields of :class:`ucon.learning.run.options.BeliefOptions`.

    Raises:
        ConfigError: a value out of range.
        DataError: ``initial`` holds no head, a damaged one, or one of other sizes.
    """

    options_of = BeliefOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(
        self,
        head: Callable[[], nn.Module],
        dataset: HabitDataset,
        draw: Draw | None = None,
        parts: FittedParts | None = None,
        folds: Sequence[Fold] | None = None,
        **options: Any,
    ) -> None:
        self.options = given = BeliefOptions(**options)
        self.dataset, self.seed, self.steps = dataset, given.seed, given.steps
        self.weights = {"anchor": 1.0, "relation": given.relation, "relevance": given.relevance}
        torch.manual_seed(derived_seed(given.seed, "belief head"))
        self.head = head()
        draw = draw or Draw()
        self._initial = "" if given.initial is None else _load_initial(self.head, Path(given.initial).expanduser())
        if given.scene_evidence and not dataset.scenes:
            raise ConfigError(f"learner.scene_evidence=true: {dataset.name} belongs to no scenes; give false")
        if folds is None:
            folds = folds_of(dataset, given.n_folds, given.used_folds, given.scene_evidence)
        self._parts = parts or parts_of(dataset, given.scene_evidence)
        # Where the dataset lists what stands in a scene, only that can be a candidate.
        others = () if dataset.standing else dataset.anchors if dataset.scenes else None
        self._folds = [
            (KnowledgeBases(f.dataset, f.parts.known), Draws(f.parts, draw, others, f.pairs), f.pairs) for f in folds
        ]
        self._chosen_by = KnowledgeBases(dataset, self._parts.known)
        self.updates = Updates(self.head, lr=given.lr, decay=given.decay, average=given.average)

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the habits, of the fitted parts and, if given, of the initial weights."""
        initial = {"initial": self._initial} if self._initial else {}
        return {"habits": self.dataset.sha256, "parts": self._parts.sha256, **initial}

    def training_sample(self, number: int) -> Sample:
        """Training sample ``number``, from 0: a household of the ``train`` part, from the folds in turn."""
        bases, draws, pairs = self._folds[number % len(self._folds)]
        rng = stream(self.seed, "belief", number)
        seed, mode = derived_seed(self.seed, "kb", number), draws.mode(rng)
        kb = bases.drawn("train", seed, mode) if pairs is None else bases.asked("train", seed, mode, pairs)
        return draws(kb, rng, bases.candidates(kb))

    def step(self) -> Figures:
        """Update the head on ``households`` samples.

        Returns:
            ``loss`` and its terms ``anchor``, ``relation`` and ``relevance``, with ``gradient`` and ``rate``.

        Raises:
            DivergedError: a gradient that is not finite.
        """
        self.head.train()
        torch.manual_seed(derived_seed(self.seed, "dropout", self._done))
        self.updates.begin()
        total = dict.fromkeys(("loss", *self.weights), 0.0)
        for k in range(self.options.households):
            one = self.training_sample(self._done * self.options.households + k)
            found = losses(self.head(one.inputs), one.truth)
            loss = sum((self.weights[name] * value for name, value in found.items()), torch.zeros(()))
            (loss / self.options.households).backward()  # type: ignore[no-untyped-call]
            for name, value in {"loss": loss, **found}.items():
                total[name] += float(value.detach()) / self.options.households
        updated = self.updates.take(
            self._done, self.options.lr * schedule(self._done, self.steps, self.options.warm_up)
        )
        self._done += 1
        return {**total, **updated}

    @cached_property
    def validation(self) -> list[Sample]:
        """Validation samples of the val part; the same for every run and seed, so that runs can be compared."""
        return self._samples("val", _CHOOSE, self.options.n_kbs)

    def _samples(self, part: Split, first: int, count: int) -> list[Sample]:
        """Samples of ``count`` knowledge bases: every target at every habit level."""
        found = []
        for kb in self._chosen_by.several(part, first, count):
            asked = self._chosen_by.targets(kb, part)
            targets = [target for target in asked for _ in FIXED_LEVELS]
            found.append(sample(kb, self._parts, self._chosen_by.candidates(kb), targets, FIXED_LEVELS * len(asked)))
        return found

    def validate(self) -> Figures:
        """Figures of the averaged head on the val part, by habit level: ``LEVEL/nll``, ``LEVEL/ece`` and others.

        ``score`` is minus the mean NLL (nats) over levels.
        """
        with self.updates.averaged():
            found = self._figures(self.validation)
        nll = [found[f"{level}/nll"] for level in FIXED_LEVELS]
        return found | {"score": -round(float(np.mean(nll)), 6)}

    def _figures(self, samples: list[Sample]) -> Figures:
        """By habit level: means of :func:`~ucon.readers.belief_scores.scores`, and the calibration error."""
        rows: dict[str, list[dict[str, float]]] = {str(level): [] for level in FIXED_LEVELS}
        best: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {str(level): [] for level in FIXED_LEVELS}
        for one in ticked("validating", samples):
            p, relation = self._predict(one)
            for t, level in enumerate(one.levels):
                rows[level].append(scores(p[t], relation[t], one.truth.relation[t]))
                best[level].append(best_of(p[t], one.truth.anchor[t, :-1]))
        out: Figures = {}
        for name_of, found in rows.items():
            out |= {f"{name_of}/{name}": round(float(np.mean([row[name] for row in found])), 4) for name in found[0]}
            stated, true = (np.concatenate(values) for values in zip(*best[name_of], strict=True))
            out[f"{name_of}/ece"] = round(calibration_error(stated, true), 4)
        return out

    def _predict(self, one: Sample) -> tuple[np.ndarray, np.ndarray]:
        """Probabilities of the T targets' C candidates, (T, C), and of relations given the anchor, (T, C, 4)."""
        self.head.eval()
        with torch.no_grad():
            outputs = self.head(one.inputs)
        return outputs.log_p.exp().numpy()[:, :-1], outputs.relation.softmax(-1).numpy()

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all; always True."""
        self.steps = steps
        return True

    def product(self) -> Mapping[str, bytes]:
        """Files of the trained head: averaged weights as float16 with a fitted temperature, and its options as JSON.

        For a dataset bound to scenes also its prior, and its reader of places if it has one.
        """
        half = {name: value.half().contiguous() for name, value in self.updates.average.items()}
        half["temperature"] = torch.tensor(self._temperature())
        options: dict[str, Any] = {"head": self.head.options, "parts": self.identity["parts"]}
        files = {WEIGHTS: save(half)}
        if (prior := self._parts.own_prior) is not None:
            options["anchors"], files[PRIOR] = list(prior.names), prior.to_bytes()
        if (own := self._parts.scene_evidence) is not None:
            options["own_places"], files = own.sha256, files | own.files
        return {**files, CONFIG: (json.dumps(options, indent=1, sort_keys=True) + "\n").encode()}

    def _temperature(self) -> float:
        """Temperature of the averaged head's logits with the least NLL on further households of the val part."""
        samples = self._samples("val", _CALIBRATE, self.options.n_kbs)
        with self.updates.averaged(), torch.no_grad():
            self.head.eval()
            scores = [self.head(one.inputs) for one in samples]
        grid = np.geomspace(0.6, 1.8, 61)

        def nll(temperature: float) -> float:
            values = [
                -(torch.from_numpy(one.truth.anchor) * _log_p_at(score, temperature)).sum(1)
                for one, score in zip(samples, scores, strict=True)
            ]
            return float(torch.cat(values).mean())

        return float(min(grid, key=nll))

    def close(self) -> None:
        """Nothing to close: it has neither workers nor environments."""

    def _own_reader(self) -> str:
        """Sentence of the model card about the dataset's own reader of places; empty where it has none."""
        if self._parts.scene_evidence is None:
            return ""
        return (
            "What reads places is an adapter of the encoder that comes with it (fp16), taught by where the things of "
            "the same entries are kept, without being told which sentence says so.\n\n"
        )

    def card(self) -> Card:
        """Text of the model card: inputs, outputs, training entries and limits."""
        parts = entry_parts(self.dataset)
        chosen = sum(part == "val" for part in parts.values())
        read = {e.id for bases, *_ in self._folds for e in bases.dataset.entries}
        taught = sum(parts.get(id) == "train" for id in read)
        size = sum(value.numel() for value in self.updates.parameters.values())
        whose = "this dataset's" if self.dataset.scenes else "the habit book's"
        return Card(
            "Belief head: where a thing may be, by what the habits say",
            f"A network of {size:,} parameters (fp16). It reads sentence vectors (all-MiniLM-L6-v2, Apache-2.0), pair "
            "features and what the fitted anchor reader says of each sentence, and gives p(anchor), p(relation | "
            "anchor), the relevance of every habit and the mass of what was not seen.\n\n"
            f"{self._own_reader()}"
            f"Trained on {taught} `train` entries of `{self.dataset.name}` (read by parts that were not fitted on "
            f"them), chosen and calibrated on its {chosen} `val` entries; `test` entries were not read. "
            "One set of weights for all habit levels.\n\n"
            "It reads English sentences about where people keep things. Its probabilities are those of "
            f"{whose} households: elsewhere they are too sure.",
            self.dataset.name,
        )


def head_tensors(path: Path, head: nn.Module) -> dict[str, Tensor]:
    """Read the weights of a head from a file that its folder's manifest lists.

    Args:
        path: safetensors file.
        head: has the names and shapes that are expected.

    Returns:
        Tensors by name, float32.

    Raises:
        DataError: missing, altered or not safetensors; of other names or shapes; or values that are not finite.
    """
    return {name: value.float() for name, value in read_fitting(path, head.state_dict())[0].items()}


def _load_initial(head: nn.Module, folder: Path) -> str:
    """Load the weights of another head, with temperature 1; returns the SHA-256 of their file."""
    path = (folder / MODEL if (folder / MODEL).is_dir() else folder) / WEIGHTS
    head.load_state_dict(head_tensors(path, head) | {"temperature": torch.ones(())})
    return sha256_file(path)


def _log_p_at(outputs: Any, temperature: float) -> Tensor:
    """Log-probabilities (T, C + 1) at a temperature."""
    logits = torch.cat([outputs.anchor, outputs.unseen[:, None]], 1)
    return (logits / temperature).log_softmax(1).clamp_min(-30.0)
