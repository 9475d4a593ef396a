"""Builds what the belief head reads (:mod:`ucon.readers.head_inputs`) from sentences and names.

What a sentence says is read once a household; candidates may grow while a home is explored, and several targets may
be asked for in turn: each adds its own part.
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
    """The fitted parts of the anchor reader: evidence, gate, common sense. Remembers what it has read by text."""

    def __init__(
        self,
        weights: ReaderWeights,
        pairs: PairReader,
        evidence: EvidenceReader | SceneEvidence | None = None,
        own_prior: AnchorPrior | None = None,
    ) -> None:
        """``evidence``: says what sentences speak for, else the weights do; ``own_prior``: a dataset's common sense."""
        self.weights, self.pairs, self.own_prior = weights, pairs, own_prior
        self.evidence = evidence or EvidenceReader(weights, pairs)
        self.scene_evidence = evidence if isinstance(evidence, SceneEvidence) else None
        self.known = weights.anchors if self.scene_evidence is None else self.scene_evidence.known
        self.number = {name: i for i, name in enumerate(self.known)}
        self._usual_row = {name: i for i, name in enumerate(weights.anchors)}

    @property
    def sha256(self) -> str:
        """Hash of what they were fitted to be."""
        return sha256_bytes(f"{self.weights.sha256} {getattr(self.evidence, 'sha256', '')}".encode())

    def vectors(self, texts: Sequence[str]) -> Array:
        """Unit vectors (n, D)."""
        return self.pairs.encoder.encode_half(texts).astype(np.float64)

    def prior(self, targets: Sequence[str], names: Sequence[str]) -> Array:
        """Log p(anchor | target) (T, C): common sense, one value for all names that it does not know."""
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
        """p(relation | anchor) (C, 4); all relations alike for names that nothing is known of."""
        table, row, even = self.weights["relation_prior"], self._usual_row, np.full(len(RELATIONS), 1 / len(RELATIONS))
        own = {} if self.own_prior is None else self.own_prior.relations
        rows = [own[name] if name in own else table[row[name]] if name in row else even for name in names]
        return np.stack(rows) if rows else np.zeros((0, len(RELATIONS)))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Names with what is known of them alone."""

    names: tuple[str, ...]
    vectors: Array  # (C, D)
    known: NDArray[np.bool_]  # (C,) the fitted parts know the name
    relation_prior: Array  # (C, 4)

    @classmethod
    def of(cls, names: Sequence[str], parts: FittedParts) -> Candidates:
        """Look the names up."""
        known = np.asarray([name in parts.number for name in names], bool)
        return cls(tuple(names), parts.vectors([phrase(name) for name in names]), known, parts.relation_prior(names))


class Household:
    """H sentences, read."""

    def __init__(self, parts: FittedParts, texts: Sequence[str]) -> None:
        self.parts, self.texts = parts, tuple(texts)
        self.vectors = parts.vectors(self.texts)
        self.said: Evidence = parts.evidence.read(self.texts)
        self._lexical: dict[str, Array] = {}

    def columns(self, candidates: Candidates) -> NDArray[np.float32]:
        """Pair inputs (H, C, N_PAIR)."""
        features = self.parts.pairs.features(self.texts, candidates.names)
        return pair_columns(features, self.spoken(candidates, features), candidates.known)

    def spoken(self, candidates: Candidates, features: NDArray[np.floating] | None = None) -> Array:
        """(H, C): probability that each sentence speaks for each candidate, whosever place it is."""
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
        """(H,) cosine of each sentence with the paper's query for a target."""
        return np.round(self.vectors @ self.parts.vectors([query_text(target)])[0], DECIMALS)

    def look_up(self, targets: Sequence[str]) -> None:
        """Read pair features with several targets at once, which costs little more than one."""
        new = [target for target in dict.fromkeys(targets) if target not in self._lexical]
        features = self.parts.pairs.features(self.texts, new).astype(np.float64)
        self._lexical.update((target, features[:, i]) for i, target in enumerate(new))

    def relevance(self, target: str, rows: NDArray[np.intp] | slice = slice(None)) -> NDArray[np.float32]:
        """Relevance inputs (H', N_RELEVANCE) of the given sentences, each seen among them."""
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
    ) -> HeadInputs:
        """All the head reads, for targets that are given some sentences each.

        Args:
            targets: T names.
            candidates: C names.
            given: (T, H) the sentences that each target is given.
            trusted: (T,) all of them are about the target.
            pair: :meth:`columns` of the candidates, where they were made before.
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
        )


@cache
def default_parts() -> FittedParts:
    """The shipped parts, one set per process."""
    return parts_with(None)


def parts_with(own_prior: AnchorPrior | None, scene_evidence: Path | None = None) -> FittedParts:
    """The shipped parts, with the common sense of a dataset in place of the habit book's.

    ``scene_evidence``: folder of what reads places in its sentences
    (:class:`~ucon.readers.scene_evidence.SceneEvidence`).
    """
    pairs, shipped = default_pair_reader(), shipped_evidence()
    evidence = shipped if scene_evidence is None else SceneEvidence.load(scene_evidence, pairs, shipped)
    return FittedParts(default_weights(), pairs, evidence, own_prior)


@cache
def shipped_evidence() -> TunedEvidence:
    """What reads places by default, one per process."""
    return TunedEvidence(default_weights(), default_pair_reader(), book_table())
