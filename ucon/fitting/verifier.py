"""Fits and measures the verifier: ``python -m ucon data fit-verifier [--json]``, a minute on one core.

Evidence is fitted on the habit book's train entries; the logistic model on top of it on val categories, whose sentences
the evidence has not seen; test categories are only measured. Negatives of a sentence: anchors that its entry does not
use, drawn by frequency; other placements of the entry; and, for sentences that support nothing, all placements of it.
"""

from __future__ import annotations

import argparse
import io
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.files import write_atomic
from ucon.core.rng import stream
from ucon.fitting.anchor_reader import fit_evidence
from ucon.generation.verify import INPUTS, WEIGHTS, Verifier, default_verifier, pack
from ucon.habits.book import book, book_anchors
from ucon.habits.splits import category_split, entry_parts
from ucon.habits.types import Entry, HabitDataset, Placement
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.store import write_manifest_of
from ucon.objects.model import RELATIONS
from ucon.readers.reader_weights import Array, pack_names

SWAPPED: Final = 4
"""Swapped anchors per supporting sentence."""
_DRAWN: Final = 16
"""Swapped anchors per entry, which its sentences share."""
PAIR_KINDS: Final = ("supported", "swapped", "other", "distractor")
_INPUTS_OF_EVIDENCE: Final = ("vocabulary", "dense", "bias", "pair", "any")
Arrays = dict[str, NDArray]


@dataclass(frozen=True)
class Pairs:
    """Inputs of the logistic model for (sentence, placement) pairs, by kind of pair; each (n, inputs)."""

    of: dict[str, Array]

    def auroc(self, head: Array, kind: str) -> float:
        """Probability that a supported pair scores higher than one of another kind.

        Args:
            head: (inputs + 1,) weights and bias.
            kind: of :data:`PAIR_KINDS`.
        """
        right, wrong = self.of["supported"] @ head[:-1], self.of[kind] @ head[:-1]
        return auroc(right, wrong)


def frequencies(entries: Sequence[Entry], anchors: Sequence[str]) -> Array:
    """Smoothed frequency of each anchor in the entries' placements, (A,); sums to 1."""
    counts = np.full(len(anchors), 0.5)
    number = {name: i for i, name in enumerate(anchors)}
    for entry in entries:
        for placement in entry.placements:
            counts[number[placement.anchor]] += 1
    return counts / counts.sum()


def labelled_pairs(verifier: Verifier, entries: Sequence[Entry], frequency: Array, seed: int = 0) -> Pairs:
    """All kinds of pairs of some entries. Swaps are drawn per entry, so other entries do not change them.

    Args:
        verifier: computes the inputs.
        entries: whose sentences and placements.
        frequency: (A,) of the anchors.
        seed: of the swaps.
    """
    found: dict[str, list[Array]] = {kind: [] for kind in PAIR_KINDS}
    anchors = list(verifier.known)
    for entry in entries:
        swaps, rng = swaps_of(entry, anchors, frequency, seed)
        x = verifier.inputs([h.text for h in entry.habits], [*entry.placements, *swaps])
        n = len(entry.placements)
        for row, habit in zip(x, entry.habits, strict=True):
            for j in range(n):
                kind = "supported" if j in habit.supports else "other" if habit.supports else "distractor"
                found[kind].append(row[j])
            if habit.supports:
                found["swapped"] += [row[n + k] for k in rng.permutation(len(swaps))[:SWAPPED]]
    return Pairs({kind: np.stack(rows) if rows else np.zeros((0, len(INPUTS))) for kind, rows in found.items()})


def swaps_of(
    entry: Entry, anchors: Sequence[str], frequency: Array, seed: int
) -> tuple[list[Placement], np.random.Generator]:
    """Placements at anchors that an entry does not use, drawn by frequency, and the generator that drew them.

    Args:
        entry: whose anchors are left out.
        anchors: A names.
        frequency: (A,) of the anchors.
        seed: of the draws.
    """
    rng = stream(seed, "verifier", "swap", entry.id)
    used = {p.anchor for p in entry.placements}
    p = np.asarray([0.0 if name in used else f for name, f in zip(anchors, frequency, strict=True)])
    return [_swap(anchors[i], rng) for i in rng.choice(len(anchors), size=_DRAWN, p=p / p.sum())], rng


def _swap(anchor: str, rng: np.random.Generator) -> Placement:
    relations = [r for r in RELATIONS if r in book_anchors().get(anchor, RELATIONS)]
    return Placement(relations[int(rng.integers(len(relations)))], anchor)


def fit_head(pairs: Pairs, l2: float = 1e-3) -> Array:
    """Logistic regression of supported pairs against all others.

    Args:
        pairs: inputs by kind.
        l2: penalty of the standardised weights.

    Returns:
        (inputs + 1,) weights and bias.
    """
    import torch

    x = np.concatenate([pairs.of[kind] for kind in PAIR_KINDS])
    y = torch.tensor(np.repeat([1.0, 0.0], [len(pairs.of["supported"]), len(x) - len(pairs.of["supported"])]))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-6
    inputs = torch.tensor((x - mean) / spread)
    weight = torch.zeros(x.shape[1] + 1, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([weight], max_iter=200)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        logits = inputs @ weight[:-1] + weight[-1]
        loss = torch.nn.functional.binary_cross_entropy_with_logits(logits, y) + l2 * (weight[:-1] ** 2).sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    found = weight.detach().numpy()
    slopes = found[:-1] / spread
    return np.append(slopes, found[-1] - slopes @ mean)


def fit(data: HabitDataset, pairs: PairReader) -> Arrays:
    """All arrays of a verifier, by name.

    Args:
        data: the dataset.
        pairs: encodes sentences and pairs.
    """
    anchors, parts = list(data.anchors), entry_parts(data)
    frequency = frequencies([e for e in data.entries if parts[e.id] == "train"], anchors)
    evidence = fit_evidence(data, pairs, anchors)
    arrays: Arrays = {name: evidence[name] for name in _INPUTS_OF_EVIDENCE}
    arrays["dense"] = arrays["dense"].astype(np.float16)
    arrays |= {"anchors": pack_names(anchors), "frequency": frequency, **pack(evidence["bow"].astype(np.float32))}
    blank = Verifier({**arrays, "head": np.zeros(len(INPUTS) + 1)}, pairs=pairs)
    held_out = labelled_pairs(blank, [e for e in data.entries if parts[e.id] == "val"], frequency)
    return {**arrays, "head": fit_head(held_out)}


def measure(data: HabitDataset, verifier: Verifier, wanted: Callable[[Entry], bool]) -> dict[str, float]:
    """AUROC of supported pairs against each other kind, and the number of pairs of each kind.

    Args:
        data: the dataset.
        verifier: what is measured.
        wanted: which entries count.
    """
    entries = [entry for entry in data.entries if wanted(entry)]
    pairs = labelled_pairs(verifier, entries, verifier.frequency, seed=1)
    out = {f"auroc_{kind}": round(pairs.auroc(verifier.head, kind), 4) for kind in PAIR_KINDS[1:]}
    return out | {kind: len(rows) for kind, rows in pairs.of.items()}


def held_out(data: HabitDataset) -> dict[str, Callable[[Entry], bool]]:
    """Which entries count, by part: val, test categories, and test entries of train categories."""
    parts = entry_parts(data)
    return {
        "val": lambda e: parts[e.id] == "val",
        "test": lambda e: category_split(e.category) == "test",
        "test_entries_of_training_categories": lambda e: (
            parts[e.id] == "test" and category_split(e.category) == "train"
        ),
    }


def auroc(right: Array, wrong: Array) -> float:
    """Probability that a value of ``right`` exceeds one of ``wrong``; ties count half."""
    below = np.sort(wrong)
    wins = np.searchsorted(below, right, "left") + np.searchsorted(below, right, "right")
    return float(wins.mean() / (2 * len(wrong)))


def main(words: Sequence[str]) -> None:
    """Fit, write, and print the figures.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(prog="ucon data fit-verifier")
    parser.add_argument("--json", action="store_true", help="print JSON")
    args = parser.parse_args(words)
    import torch

    torch.set_num_threads(1)
    buffer = io.BytesIO()
    arrays = fit(book(), default_pair_reader())
    packed = {k: v.astype(np.float32) if v.dtype == np.float64 else v for k, v in arrays.items()}
    np.savez_compressed(buffer, **packed)  # type: ignore[arg-type]
    write_atomic(WEIGHTS, buffer.getvalue())
    write_manifest_of(WEIGHTS.parent)
    default_verifier.cache_clear()
    figures = {part: measure(book(), default_verifier(), wanted) for part, wanted in held_out(book()).items()}
    if args.json:
        print(json.dumps(figures, indent=1))  # noqa: T201
        return
    for part, row in figures.items():
        print(f"{part}: " + "  ".join(f"{name} {value:g}" for name, value in row.items()))  # noqa: T201
