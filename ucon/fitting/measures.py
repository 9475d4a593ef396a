"""Measures retrieval and the anchor reader on held-out categories: ``python -m ucon data measure-readers [--json]``.

Each knowledge base holds 20 test categories; the truth is the distribution over placements that episodes are drawn
from. Candidates are all known anchors; lines marked "clutter" add 85 other categories of the catalogue, as a home
would.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ucon.habits.book import book
from ucon.habits.knowledge import MODES, KnowledgeBase, Mode
from ucon.habits.splits import Split
from ucon.habits.types import Entry, HabitDataset
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_reader import AnchorReader
from ucon.readers.sampled_homes import anchor_distribution, location_distribution, sampled_kb
from ucon.retrieval.base import Retriever, mrr, recall_at
from ucon.retrieval.bm25 import BM25Retriever
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.levels import FIXED_LEVELS, habits_at_level

Row = dict[str, float]


def measure_retrieval(
    kbs: Sequence[KnowledgeBase], retriever: Retriever, about: Callable[[Entry], bool] = lambda _: True
) -> Row:
    """Means over all targets: MRR, recall of the target's habits at 10 and 20, and of its supporting habits at 20.

    The last one is left out where supports are unknown.

    Args:
        kbs: knowledge bases.
        retriever: what is measured.
        about: which entries count; a target needs all its entries to count.
    """
    rows: list[Row] = []
    for kb in kbs:
        for target in (name for name, entries in kb.entries.items() if all(map(about, entries))):
            ranking, own = retriever.rank(target, kb), kb.rows_about(target)
            supporting = [row for row in own if kb.dataset.habits[row].supports]
            found = {f"recall_at_{k}": recall_at(ranking, own, k) for k in (10, 20)}
            known = {"supporting_at_20": recall_at(ranking, supporting, 20)} if kb.dataset.labelled else {}
            rows.append({"mrr": mrr(ranking, own), **found, **known})
    return _means(rows)


def measure_reader(
    kbs: Sequence[KnowledgeBase], level: str, reader: AnchorReader, retriever: Retriever, clutter: Sequence[str] = ()
) -> Row:
    """Means over all targets: hit@1, hit@5, NLL, expected visits, relation accuracy, mass of the top three.

    The last one is given as stated and as true.

    Args:
        kbs: knowledge bases.
        level: habit level.
        reader: what is measured.
        retriever: for level ``retrieval``.
        clutter: candidates that are no anchors of the book.
    """
    rows: list[Row] = []
    for kb in kbs:
        for target, entries in kb.entries.items():
            texts = [kb.dataset.texts[row] for row in habits_at_level(level, kb, target, retriever)]
            belief = reader.belief(target, texts, [*reader.known, *clutter], trusted=level == "gt")
            truth = anchor_distribution(entries)
            y = np.asarray([truth.get(name, 0.0) for name in belief.candidates])
            rows.append(_scores(belief.p, y) | _relation(belief.relation, location_distribution(entries), reader.known))
    return _means(rows)


def _scores(p: NDArray[np.float64], y: NDArray[np.float64]) -> Row:
    order = np.argsort(-p, kind="stable")
    visits = float((y[order] * np.arange(1, len(y) + 1)).sum())
    nll = float(-(y * np.log(np.maximum(p, 1e-12))).sum())
    hits = {f"hit_at_{k}": float(y[order[:k]].sum()) for k in (1, 5)}
    top = order[:3]
    return {
        **hits,
        "nll": nll,
        "visits": visits,
        "top_3_stated": float(p[top].sum()),
        "top_3_true": float(y[top].sum()),
    }


def _relation(p: NDArray[np.float64], truth: dict[tuple[str, str], float], known: Sequence[str]) -> Row:
    right = sum(
        value for (anchor, relation), value in truth.items() if RELATIONS[p[known.index(anchor)].argmax()] == relation
    )
    return {"relation": float(right)}


def _means(rows: Sequence[Row]) -> Row:
    return {key: round(float(np.nanmean([row[key] for row in rows])), 4) for key in rows[0]}


def measure(
    data: HabitDataset, split: Split = "test", n_kbs: int = 20, modes: Sequence[Mode] = MODES, say: Callable = print
) -> dict[str, dict[str, Row]]:
    """All figures, by mode of the knowledge bases and then by method or habit level.

    Args:
        data: the dataset.
        split: ``val`` or ``test``.
        n_kbs: knowledge bases per mode.
        modes: ``task``, ``category``.
        say: is called with a line of text for each.
    """
    dense, reader = DenseRetriever(), AnchorReader()
    clutter = [name for name in catalogue().names if name not in reader.number][::9]
    out: dict[str, dict[str, Row]] = {}
    for mode in modes:
        kbs = [sampled_kb(data, split, 10_000 + seed, mode) for seed in range(n_kbs)]
        size = float(np.mean([len(kb) for kb in kbs]))
        rows = {"dense": measure_retrieval(kbs, dense), "bm25": measure_retrieval(kbs, BM25Retriever())}
        rows |= {level: measure_reader(kbs, level, reader, dense) for level in FIXED_LEVELS}
        rows |= {f"{level}+clutter": measure_reader(kbs, level, reader, dense, clutter) for level in ("none", "gt")}
        for name, row in rows.items():
            say(f"{mode:9s} N={size:.0f} {name:12s} " + "  ".join(f"{k} {v:.3f}" for k, v in row.items()))
        out[mode] = rows
    return out


def main(words: Sequence[str]) -> None:
    """Run the command: print a line per method, or JSON.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(prog="ucon data measure-readers")
    parser.add_argument("--json", action="store_true", help="print JSON")
    args = parser.parse_args(words)
    found = measure(book(), say=(lambda _: None) if args.json else print)
    if args.json:
        print(json.dumps(found, indent=1))  # noqa: T201
