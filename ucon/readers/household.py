"""Builds the belief head's inputs (:mod:`ucon.readers.head_inputs`) from sentences and names.

Sentences are read once per household. Candidates may be added while a home is explored, and several targets may be
asked about in turn; each adds only its own part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ucon.core.files import sha256_bytes
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.phrases import phrase, query_text
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import UNKNOWN_PRIOR, AnchorPrior
from ucon.readers.evidence import Evidence, EvidenceReader
from ucon.readers.gate import DECIMALS, gate_inputs, set_features
from ucon.readers.head_inputs import (
    N_CANDIDATE,
    N_RELEVANCE,
    HeadInputs,
    habit_columns,
    pair_columns,
    unknown_said,
)
from ucon.readers.reader_weights import Array, ReaderWeights, default_weights, softmax
from ucon.readers.scene_evidence import SceneEvidence
from ucon.readers.tuned_evidence import TunedEvidence, book_table


class FittedParts:
    """The fitted parts of the anchor reader: evidence, gate and prior. Caches what it has read by text."""

    def __init__(
        self,
        weights: ReaderWeights,
        pairs: PairReader,
        evidence: EvidenceReader | SceneEvidence | None = None,
        own_prior: AnchorPrior | None = None,
    ) -> None:
        """Combine the parts.

        Args:
            weights: of evidence, gate and prior.
            pairs: encodes sentences and pairs.
            evidence: reads which places sentences speak for; by default the reader in ``weights``.
            own_prior: prior of a dataset with anchors of its own.
        """
        self.weights, self.pairs, self.own_prior = weights, pairs, own_prior
        self.evidence = evidence or EvidenceReader(weights, pairs)
        self.scene_evidence = evidence if isinstance(evidence, SceneEvidence) else None
        self.known = weights.anchors if self.scene_evidence is None else self.scene_evidence.known
        self.number = {name: i for i, name in enumerate(self.known)}
        self._usual_row = {name: i for i, name in enumerate(weights.anchors)}

    @property
    def sha256(self) -> str:
        """Hash of the weights of evidence, gate and prior."""
        return sha256_bytes(f"{self.weights.sha256} {getattr(self.evidence, 'sha256', '')}".encode())

    def vectors(self, texts: Sequence[str]) -> Array:
        """Unit vectors (n, D) of texts, float64."""
        return self.pairs.encoder.encode_half(texts).astype(np.float64)

    def prior(self, targets: Sequence[str], names: Sequence[str]) -> Array:
        """Log p(anchor | target), (T, C), before reading; one constant for all names outside the prior.

        Args:
            targets: T categories.
            names: C candidates.
        """
        vectors = self.vectors([phrase(target) for target in targets])
        if self.own_prior is not None:
            return self.own_prior.log_p(vectors, names, UNKNOWN_PRIOR)
        logits = np.round(vectors @ self.weights["prior_dense"] + self.weights["prior_bias"], DECIMALS)
        known = np.log(softmax(logits))
        out = np.full((len(targets), len(names)), UNKNOWN_PRIOR)
        for i, name in enumerate(names):
            if name in self._usual_row:
                out[:, i] = known[:, self._usual_row[name]]
        return out

    def relation_prior(self, names: Sequence[str]) -> Array:
        """p(relation | anchor), (C, 4), before reading; uniform for unknown names."""
        table, row, even = self.weights["relation_prior"], self._usual_row, np.full(len(RELATIONS), 1 / len(RELATIONS))
        own = {} if self.own_prior is None else self.own_prior.relations
        rows = [own[name] if name in own else table[row[name]] if name in row else even for name in names]
        return np.stack(rows) if rows else np.zeros((0, len(RELATIONS)))


@dataclass(frozen=True, eq=False)
class Candidates:
    """C candidate names with their vectors and priors."""

    names: tuple[str, ...]
    vectors: Array
    """(C, D) unit vectors of the names."""
    known: NDArray[np.bool_]
    """(C,) True for names that the fitted parts know."""
    relation_prior: Array
    """(C, 4) p(relation | anchor) before reading."""

    @classmethod
    def of(cls, names: Sequence[str], parts: FittedParts) -> Candidates:
        """Look up names.

        Args:
            names: C categories.
            parts: give vectors and priors.
        """
        known = np.asarray([name in parts.number for name in names], bool)
        return cls(tuple(names), parts.vectors([phrase(name) for name in names]), known, parts.relation_prior(names))


class Household:
    """H sentences of a household, with vectors and evidence.

    Args:
        parts: read the sentences.
        texts: the sentences.
    """

    def __init__(self, parts: FittedParts, texts: Sequence[str]) -> None:
        self.parts, self.texts = parts, tuple(texts)
        self.vectors = parts.vectors(self.texts)
        self.said: Evidence = parts.evidence.read(self.texts)
        self._lexical: dict[str, Array] = {}

    def columns(self, candidates: Candidates) -> NDArray[np.float32]:
        """Features of all (habit, candidate) pairs, (H, C, N_PAIR) float32."""
        features = self.parts.pairs.features(self.texts, candidates.names)
        return pair_columns(features, self.spoken(candidates, features), candidates.known)

    def spoken(self, candidates: Candidates, features: NDArray[np.floating] | None = None) -> Array:
        """Probability (H, C) that each sentence speaks for each candidate, whichever target it is about.

        Args:
            candidates: C names.
            features: (H, C, 6) pair features, if they were computed before.
        """
        known = candidates.known
        if features is None:
            features = self.parts.pairs.features(self.texts, candidates.names)
        if self.parts.scene_evidence is not None:
            return self.parts.scene_evidence.spoken(self.texts, candidates.names, features)
        said = unknown_said(features, self.parts.weights["any"], self.said.place)
        names = [name for name, met in zip(candidates.names, known, strict=True) if met]
        said[:, known] = self.said.anchor[:, [self.parts.number[name] for name in names]]
        return said

    def cosines(self, target: str) -> Array:
        """(H,) cosine of each sentence with the paper's query for a target, rounded to 1e-4."""
        return np.round(self.vectors @ self.parts.vectors([query_text(target)])[0], DECIMALS)

    def look_up(self, targets: Sequence[str]) -> None:
        """Compute pair features of the sentences with several targets at once, which costs little more than one."""
        new = [target for target in dict.fromkeys(targets) if target not in self._lexical]
        features = self.parts.pairs.features(self.texts, new).astype(np.float64)
        self._lexical.update((target, features[:, i]) for i, target in enumerate(new))

    def relevance(self, target: str, rows: NDArray[np.intp] | slice = slice(None)) -> NDArray[np.float32]:
        """Features (H', N_RELEVANCE) of sentences for a target, computed within the set of these sentences.

        Args:
            target: category that is looked for.
            rows: indices of the H' sentences; all by default.
        """
        self.look_up([target])
        vectors = self.vectors[rows]
        if not len(vectors):
            return np.zeros((0, N_RELEVANCE), np.float32)
        features = set_features(self._lexical[target][rows], self.cosines(target)[rows], vectors)
        name = self.parts.vectors([phrase(target)])[0]
        inputs = gate_inputs(features, vectors, name, self.parts.weights)
        if self.parts.scene_evidence is not None:
            texts = [self.texts[k] for k in np.arange(len(self.texts))[rows]]
            inputs[:, -1] = self.parts.scene_evidence.about(target, texts)
        return inputs.astype(np.float32)

    def inputs(
        self,
        targets: Sequence[str],
        candidates: Candidates,
        given: NDArray[np.bool_],
        trusted: NDArray[np.bool_],
        pair: NDArray[np.float32] | None = None,
        holds: Array | None = None,
    ) -> HeadInputs:
        """All inputs of the head.

        Args:
            targets: T names.
            candidates: C names.
            given: (T, H) bool, True for sentences that the target is given.
            trusted: (T,) bool, True if all of them are about the target.
            pair: :meth:`columns` of the candidates, if they were computed before.
            holds: (T, H) how much each sentence counts in the told context; None: none was told.
        """
        self.look_up(targets)
        relevance = np.zeros((len(targets), len(self.texts), N_RELEVANCE), np.float32)
        for t, target in enumerate(targets):
            rows = np.flatnonzero(given[t])
            relevance[t, rows] = self.relevance(target, rows)
        prior = self.parts.prior(targets, candidates.names)
        kinds = np.repeat(candidates.known[:, None], N_CANDIDATE, axis=1)
        return HeadInputs(
            sentence=self.vectors.astype(np.float32),
            habit=habit_columns(self.said),
            pair=self.columns(candidates) if pair is None else pair,
            name=candidates.vectors.astype(np.float32),
            candidate=kinds.astype(np.float32),
            relation_prior=candidates.relation_prior.astype(np.float32),
            target=self.parts.vectors([phrase(target) for target in targets]).astype(np.float32),
            prior=prior.astype(np.float32),
            relevance=relevance,
            given=given,
            trusted=trusted,
            open=np.asarray([[name != target for name in candidates.names] for target in targets], bool).reshape(
                len(targets), len(candidates.names)
            ),
            holds=None if holds is None else holds.astype(np.float32),
        )


@cache
def default_parts() -> FittedParts:
    """The shipped parts, one set per process."""
    return parts_with(None)


def parts_with(own_prior: AnchorPrior | None, scene_evidence: Path | None = None) -> FittedParts:
    """The shipped parts with a dataset's own prior and evidence.

    Args:
        own_prior: the dataset's prior; None: the habit book's.
        scene_evidence: folder of the dataset's own reader of places
            (:class:`~ucon.readers.scene_evidence.SceneEvidence`); None: the shipped one.

    Raises:
        DataError: files in the folder are missing or damaged.
    """
    pairs, shipped = default_pair_reader(), shipped_evidence()
    evidence = shipped if scene_evidence is None else SceneEvidence.load(scene_evidence, pairs, shipped)
    return FittedParts(default_weights(), pairs, evidence, own_prior)


@cache
def shipped_evidence() -> TunedEvidence:
    """The shipped reader of places, one per process."""
    return TunedEvidence(default_weights(), default_pair_reader(), book_table())
