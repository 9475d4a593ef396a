"""Step 3 of the pipeline: does a habit's text agree with the placements that it is labelled to support?

The verifier is a logistic model of a (sentence, placement) pair. Its inputs are what the evidence reader finds in the
sentence (log-odds of the anchor against its usual frequency, of "no place", of the relation) and the pair features of
sentence and anchor. Its weights are made by ``python -m ucon data fit-verifier``. The object's name is not an input: it
says which places are usual, not what the sentence says.

No label is changed: labels that the text does not confirm are listed for a person to check.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.habits.types import Entry, HabitDataset, Placement
from ucon.language.pairs import FEATURES, PairReader, default_pair_reader
from ucon.objects.model import RELATIONS
from ucon.readers.evidence import Evidence, EvidenceReader
from ucon.readers.reader_weights import EVIDENCE, Array, ReaderWeights, load_arrays, sigmoid

WEIGHTS: Final = Path(__file__).parent / "data" / "verifier.npz"
MADE_BY: Final = "python -m ucon data fit-verifier"
INPUTS: Final = ("odds", "chance", "no_place", "relation", *FEATURES)
"""Columns of :meth:`Verifier.inputs`."""
LOW, HIGH = 0.01, 0.9
"""A support label is doubted below the first score, its absence above the second."""
DECIMALS: Final = 4
_TINY: Final = 1e-7


@dataclass(frozen=True, slots=True)
class Doubt:
    """A label that the text does not confirm."""

    entry: str
    habit: int
    """Number of the sentence in the entry, from 0."""
    text: str
    placement: Placement
    labelled: bool
    """Whether the sentence is labelled to support the placement."""
    score: float
    """Probability of support, by the text."""

    def __str__(self) -> str:
        said = "is labelled as supporting" if self.labelled else "is not labelled as supporting"
        place = f"{self.placement.relation} {self.placement.anchor}"
        return f"{self.entry} habit {self.habit + 1} {said} '{place}' (text: {self.score:.3f}): {self.text}"


class PairScorer(Protocol):
    """Says how well sentences support placements: :class:`Verifier` or :class:`ucon.generation.asked.AskedVerifier`."""

    def scores(self, texts: Sequence[str], placements: Sequence[Placement]) -> Array:
        """Probability (H, P) that each of H sentences supports each of P placements."""
        ...


class Verifier:
    """Scores sentences against placements."""

    def __init__(self, arrays: Mapping[str, NDArray], sha256: str = "", pairs: PairReader | None = None) -> None:
        """Set the weights.

        Args:
            arrays: those of the evidence reader, ``frequency`` (A,) of its anchors, and ``head`` (inputs + 1,).
            sha256: of the weights' file.
            pairs: pair features; the shipped reader by default.

        Raises:
            DataError: an array is missing or has another shape.
        """
        unpacked = {**arrays, "bow": unpack(arrays)} if "bow_scale" in arrays else dict(arrays)
        weights = ReaderWeights(unpacked, sha256, (*EVIDENCE, "frequency", "head"), MADE_BY)
        if weights["head"].shape != (len(INPUTS) + 1,) or weights["frequency"].shape != (len(weights.anchors),):
            raise DataError(f"verifier weights do not fit this version; make them with `{MADE_BY}`")
        self.sha256 = sha256
        self.known = {name: i for i, name in enumerate(weights.anchors)}
        self._pairs = pairs or default_pair_reader()
        self._evidence = EvidenceReader(weights, self._pairs)
        self.frequency = weights["frequency"]
        """(A,): how often each known anchor is used; sums to 1."""
        self.head = weights["head"]
        self._usual = np.log(self.frequency)

    def scores(self, texts: Sequence[str], placements: Sequence[Placement]) -> Array:
        """Probability that each sentence supports each placement.

        Args:
            texts: H sentences.
            placements: P placements.

        Returns:
            (H, P) float64.
        """
        return sigmoid(np.round(self.inputs(texts, placements) @ self.head[:-1] + self.head[-1], DECIMALS))

    def inputs(self, texts: Sequence[str], placements: Sequence[Placement]) -> Array:
        """Inputs of the logistic model.

        Args:
            texts: H sentences.
            placements: P placements.

        Returns:
            (H, P, 10) float64, in the order of :data:`INPUTS`.
        """
        if not texts or not placements:
            return np.zeros((len(texts), len(placements), len(INPUTS)))
        said = self._evidence.read(texts)
        names = [p.anchor for p in placements]
        chance = np.clip(self._chance(texts, names, said), _TINY, 1 - _TINY)
        usual = [self._usual[self.known[name]] if name in self.known else self._usual.min() for name in names]
        place = np.clip(said.place, _TINY, 1 - _TINY)[:, None]
        relation = said.relation[:, [RELATIONS.index(p.relation) for p in placements]]
        columns = [
            np.log(chance) - np.asarray(usual),
            np.log(chance / (1 - chance)),
            np.broadcast_to(np.log(1 / place - 1), chance.shape),
            np.log(np.clip(relation, _TINY, 1)),
        ]
        return np.concatenate([np.stack(columns, axis=2), self._pairs.features(texts, names)], axis=2)

    def _chance(self, texts: Sequence[str], names: Sequence[str], said: Evidence) -> Array:
        """(H, P): probability that each sentence is about each anchor, known or not."""
        out = np.empty((len(texts), len(names)))
        new = sorted({name for name in names if name not in self.known})
        unknown = self._evidence.unknown(texts, new, said.place) if new else None
        for column, name in enumerate(names):
            if name in self.known:
                out[:, column] = said.anchor[:, self.known[name]]
            elif unknown is not None:
                out[:, column] = unknown[:, new.index(name)]
        return out


def doubtful(
    dataset: HabitDataset,
    verifier: PairScorer | None = None,
    *,
    low: float = LOW,
    high: float = HIGH,
    wanted: Callable[[Entry], bool] = lambda _: True,
) -> list[Doubt]:
    """Labels that the verifier doubts, the most doubtful first.

    The verifier has learned the labels of its training entries, wrong ones included, so its doubts about new entries
    are more reliable.

    Args:
        dataset: entries with labels.
        verifier: the shipped one by default.
        low: a support label with a lower score is doubted.
        high: a missing support label with a higher score is doubted.
        wanted: which entries to check.

    Raises:
        DataError: the dataset has no labels.
    """
    if not dataset.labelled:
        raise DataError(
            f"dataset '{dataset.name}' does not say which habit supports what, so there are no labels to check"
        )
    verifier = verifier or default_verifier()
    found: list[Doubt] = []
    for entry in filter(wanted, dataset.entries):
        scores = verifier.scores([habit.text for habit in entry.habits], entry.placements)
        for i, habit in enumerate(entry.habits):
            for j, placement in enumerate(entry.placements):
                labelled, score = j in habit.supports, float(scores[i, j])
                if (score < low) if labelled else (score > high):
                    found.append(Doubt(entry.id, i, habit.text, placement, labelled, score))
    return sorted(found, key=lambda doubt: doubt.score if doubt.labelled else 1 - doubt.score)


def pack(bow: NDArray) -> dict[str, NDArray]:
    """Word weights (V, K) as int8 codes with one scale a row."""
    scale = np.maximum(np.abs(bow).max(axis=1), 1e-9).astype(np.float32) / 127
    return {"bow": np.rint(bow / scale[:, None]).astype(np.int8), "bow_scale": scale}


def unpack(arrays: Mapping[str, NDArray]) -> NDArray[np.float32]:
    """Word weights (V, K) float32; the inverse of :func:`pack`."""
    return arrays["bow"].astype(np.float32) * arrays["bow_scale"].astype(np.float32)[:, None]


@cache
def default_verifier() -> Verifier:
    """The process's shipped verifier."""
    return Verifier(*load_arrays(WEIGHTS))
