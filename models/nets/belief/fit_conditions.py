"""Fits the condition reader and how strongly each reader follows it: ``python -m ucon data fit-conditions``.

Which conditions a sentence has is learned from train entries of the habit book (:mod:`ucon.fitting.conditions`). How
much a sentence then counts is chosen on the episodes of ``val_context``, whose categories and people no reader has
learned from: for retrieval by the share of sentences for the place in use among the first 20, for readers by the
likelihood of the target's true anchor, at levels retrieval and full.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from itertools import product
from typing import Final

import numpy as np

from models.nets.belief.head_reader import HeadReader, HeadReading, default_head_reader
from ucon.core.files import write_atomic
from ucon.fitting.conditions.fit import fit_conditions, measure
from ucon.habits.book import book, contexts_book
from ucon.habits.contexts import Context
from ucon.habits.knowledge import KnowledgeBase
from ucon.language.models.encoder import EncoderModel
from ucon.language.phrases import phrase
from ucon.language.store import write_manifest_of
from ucon.readers.anchor_reader import AnchorReader, default_reader
from ucon.readers.conditions.condition_reader import USES, WEIGHTS, ConditionReader, Holding, Strength
from ucon.readers.household import Household
from ucon.readers.reader_weights import Array, pack_names, softmax
from ucon.retrieval.base import ranked
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.levels import TOP_P
from ucon.retrieval.told import ToldRetriever, lifted
from ucon.task.sets import load_episodes

SET: Final = "val_context"
HOLDS: Final = (1.0, 2.0, 4.0, 8.0)
FAILS: Final = (1.0, 0.3, 0.1, 0.03)
SHARPNESS: Final = (1.0, 2.0, 3.0)
GRID: Final = tuple(Strength(*pair) for pair in product(HOLDS, FAILS))
#: For the fitted reader, whose mixing weights were fitted to habits that all count alike.
SHARPER: Final = tuple(Strength(*three) for three in product(HOLDS, FAILS, SHARPNESS))
#: Strengths whose shares in retrieval differ by less than this count as equally good.
_SAME: Final = 0.005

_DENSE: Final = DenseRetriever()

#: From target, sentences, their (G, H) weights by G strengths, the strengths and an anchor to its (G,) probabilities.
Likelihood = Callable[[str, tuple[str, ...], Array, Sequence[Strength], str], Array]


@dataclass(frozen=True)
class Case:
    """One search: what was asked, when, in which household, and where the target is."""

    target: str
    context: Context
    base: KnowledgeBase
    anchor: str
    telling: Array
    """(N,) bool by row of the knowledge base: the sentence supports the place that is in use."""


def cases(name: str = SET, every: int = 1) -> list[Case]:
    """The searches of a set whose episodes state their context.

    Args:
        name: of the set.
        every: take every ``every``-th episode.
    """
    data, found = contexts_book(), []
    for episode in load_episodes(name)[::every]:
        drawn: dict[str, list[object]] = {}
        for entry_id in episode.entries:
            entry = data.entries[data.entry_number[entry_id]]
            drawn.setdefault(entry.category, []).append(entry)
        base = KnowledgeBase.build(data, drawn, episode.seed)  # type: ignore[arg-type]
        entry_id, place = episode.placed_by[episode.target]
        number = data.entry_number[entry_id]
        telling = [data.row_entry[row] == number and place in data.habits[row].supports for row in base.rows]
        anchor = data.entries[number].placements[place].anchor
        assert episode.context is not None
        found.append(Case(episode.target_category, episode.context, base, anchor, np.asarray(telling)))
    return found


def retrieved_shares(found: Sequence[Case], conditions: ConditionReader) -> dict[Strength, float]:
    """Share of the sentences for the place in use that are among the first 20, by strength."""
    shares: dict[Strength, list[float]] = {strength: [] for strength in GRID}
    for case in found:
        if case.telling.any():
            plain = _DENSE.scores(case.target, case.base, case.context.occasion_and_user)
            holding = conditions.holding(case.base.texts, case.context)
            for strength, of in shares.items():
                rows = ranked(lifted(plain, holding.weights(strength)), case.base.rows)[:TOP_P]
                of.append(float(np.isin(case.base.rows[case.telling], rows).mean()))
    return {strength: float(np.mean(of)) for strength, of in shares.items()}


def nats(
    found: Sequence[Case], conditions: ConditionReader, likelihood: Likelihood, grid: Sequence[Strength]
) -> dict[str, Array]:
    """Mean nats (G,) of the true anchor by G strengths, at levels retrieval and full.

    Args:
        found: the searches.
        conditions: fitted, with its strength of retrieval.
        likelihood: of the reader.
        grid: the strengths.
    """
    out: dict[str, list[Array]] = {"retrieval": [], "full": []}
    for case in found:
        best = ToldRetriever(_DENSE, case.context, conditions).rank(case.target, case.base)[:TOP_P]
        for level, rows in (("retrieval", best), ("full", case.base.rows)):
            texts = tuple(case.base.dataset.texts[row] for row in rows)
            holding: Holding = conditions.holding(texts, case.context)
            weights = np.stack([holding.weights(strength) for strength in grid])
            p = likelihood(case.target, texts, weights, grid, case.anchor)
            out[level].append(-np.log(np.maximum(p, 1e-9)))
    return {level: np.mean(values, axis=0) for level, values in out.items()}


def by_fitted_reader(reader: AnchorReader) -> Likelihood:
    """Likelihoods by the fitted anchor reader."""

    def likelihood(target: str, texts: tuple[str, ...], weights: Array, grid: Sequence[Strength], anchor: str) -> Array:
        plain = reader.read(target, texts)
        readings = (plain.weighed(row, one.sharpness) for row, one in zip(weights, grid, strict=True))
        beliefs = (reading.belief(reader.known) for reading in readings)
        return np.asarray([belief.p[belief.candidates.index(anchor)] for belief in beliefs])

    return likelihood


def by_head(reader: HeadReader) -> Likelihood:
    """Likelihoods by the belief head, all strengths in one forward pass."""

    def likelihood(target: str, texts: tuple[str, ...], weights: Array, grid: Sequence[Strength], anchor: str) -> Array:
        household = Household(reader.parts, texts)
        readings = [HeadReading(reader, target, household, False, row) for row in weights]
        reader.fill(readings, reader.known)
        beliefs = [reading.belief(reader.known) for reading in readings]
        return np.asarray([belief.p[belief.candidates.index(anchor)] for belief in beliefs])

    return likelihood


def by_encoder(anchors: Sequence[str]) -> Likelihood:
    """Likelihoods by the sentence encoder as a language model, among all anchors."""
    model = EncoderModel()

    def likelihood(target: str, texts: tuple[str, ...], weights: Array, grid: Sequence[Strength], anchor: str) -> Array:
        logits = [
            [model.label_logit(phrase(target), texts, tuple(row.tolist()), phrase(name)) for name in anchors]
            for row in weights
        ]
        return softmax(np.asarray(logits))[:, list(anchors).index(anchor)]

    return likelihood


def fitted() -> tuple[ConditionReader, Mapping[str, Mapping[str, float]]]:
    """The condition reader with its strengths, and figures of how they were chosen."""
    conditions, found = fit_conditions(book()), cases()
    shares = retrieved_shares(found, conditions)
    best = max(shares.values()) - _SAME
    # the weakest of equally good strengths, so that a misread sentence still has a chance
    conditions.strengths["retrieval"] = min((s for s in GRID if shares[s] >= best), key=lambda s: s.holds / s.fails)
    figures: dict[str, Mapping[str, float]] = {
        "retrieval": {"unweighted": shares[GRID[0]], "chosen": shares[conditions.strengths["retrieval"]]}
    }
    likelihoods = {
        "fitted": by_fitted_reader(default_reader()),
        "head": by_head(default_head_reader()),
        "language": by_encoder(default_reader().known),
    }
    for use, likelihood in likelihoods.items():
        grid = SHARPER if use == "fitted" else GRID
        levels = nats(found, conditions, likelihood, grid)
        chosen = int(np.argmin(levels["retrieval"] + levels["full"]))
        conditions.strengths[use] = grid[chosen]
        sys.stderr.write(f"{use}: {grid[chosen]}\n")
        figures[use] = {
            f"{level} {what}": float(values[k])
            for level, values in levels.items()
            for what, k in (("unweighted", 0), ("chosen", chosen))
        }
    return conditions, figures


def main(words: Sequence[str]) -> None:
    """Fit, write ``ucon/readers/data/conditions.npz`` and print what was found.

    Args:
        words: none.
    """
    argparse.ArgumentParser(prog="python -m ucon data fit-conditions", description=__doc__).parse_args(words)
    conditions, figures = fitted()
    buffer = io.BytesIO()
    np.savez(
        buffer,
        probe=conditions.probe.astype(np.float32),
        shares=conditions.shares,
        occasions=pack_names(conditions.occasions),
        words=pack_names([" ".join(sorted(words)) for words in conditions.words]),
        strengths=np.asarray([astuple(conditions.strengths[use]) for use in USES]),
    )
    write_atomic(WEIGHTS, buffer.getvalue())
    write_manifest_of(WEIGHTS.parent)
    for use in ("retrieval", *(use for use in USES if use != "retrieval")):
        told = "  ".join(f"{name} {value:.3f}" for name, value in figures[use].items())
        strength = conditions.strengths[use]
        sys.stdout.write(f"{use:<10} holds x{strength.holds:g}  fails x{strength.fails:g}  {told}\n")
    for part in ("val", "test"):
        for kind, values in measure(conditions, book(), part).items():  # type: ignore[arg-type]
            sys.stdout.write(f"{part} {kind:<9} " + "  ".join(f"{n} {v:.3f}" for n, v in values.items()) + "\n")
