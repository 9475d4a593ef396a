"""AUROC of the fitted verifier and of a language model: ``python -m ucon data measure-verifiers --path smollm2``.

Pairs are those of test categories, whose labels neither has seen: sentences with a placement that they support, with
another placement of their entry, with an anchor that the entry does not use, and sentences that support nothing with
every placement of their entry. Intervals resample the pairs of each kind.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from ucon.core.rng import stream
from ucon.fitting.verifier import PAIR_KINDS, SWAPPED, auroc, held_out, labelled_pairs, swaps_of
from ucon.generation.asked import AskedVerifier
from ucon.generation.verify import Verifier, default_verifier
from ucon.habits.book import book
from ucon.habits.types import Entry, Placement
from ucon.language.models.causal_lm import CausalModel
from ucon.readers.reader_weights import Array

Pair = tuple[str, Placement]
_RESAMPLES: Final = 2000
#: Questions between two lines of progress.
_PART: Final = 100


def labelled(verifier: Verifier, entries: Sequence[Entry], seed: int = 1) -> dict[str, list[Pair]]:
    """All pairs of some entries, by kind.

    Args:
        verifier: knows anchors and their frequency, for the swaps.
        entries: whose sentences and placements.
        seed: of the swaps.
    """
    found: dict[str, list[Pair]] = {kind: [] for kind in PAIR_KINDS}
    for entry in entries:
        swaps, rng = swaps_of(entry, list(verifier.known), verifier.frequency, seed)
        for habit in entry.habits:
            for j, placement in enumerate(entry.placements):
                kind = "supported" if j in habit.supports else "other" if habit.supports else "distractor"
                found[kind].append((habit.text, placement))
            if habit.supports:
                found["swapped"] += [(habit.text, swaps[k]) for k in rng.permutation(len(swaps))[:SWAPPED]]
    return found


def drawn(pairs: dict[str, list[Pair]], most: int, seed: int = 0) -> dict[str, list[int]]:
    """Numbers of at most ``most`` pairs of each kind."""
    return {
        kind: sorted(stream(seed, "pairs", kind).permutation(len(own))[:most].tolist()) for kind, own in pairs.items()
    }


def figures(scores: dict[str, Array], seed: int = 0) -> dict[str, Any]:
    """AUROC of supported pairs against each other kind, with 95 % intervals.

    Args:
        scores: by kind, (n,).
        seed: of the resamples.
    """
    draw, right, out = stream(seed, "resamples"), scores["supported"], {}
    for kind in PAIR_KINDS[1:]:
        wrong = scores[kind]
        again = [
            auroc(right[draw.integers(len(right), size=len(right))], wrong[draw.integers(len(wrong), size=len(wrong))])
            for _ in range(_RESAMPLES)
        ]
        low, high = np.quantile(again, [0.025, 0.975])
        out[kind] = [round(float(x), 3) for x in (auroc(right, wrong), low, high)]
    return out


def main(words: Sequence[str]) -> None:
    """Measure both, and print the figures.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(prog="ucon data measure-verifiers")
    parser.add_argument("--path", default="smollm2", help="language model: smollm2, or a folder of a chat model")
    parser.add_argument("--pairs", type=int, default=400, help="pairs of each kind, at most")
    parser.add_argument("--orders", type=int, default=2, help="orders in which yes and no are listed: 0, 1 or 2")
    parser.add_argument("--dtype", default="bfloat16", help="number format of its weights")
    args = parser.parse_args(words)
    import torch

    torch.set_num_threads(1)
    model = CausalModel(args.path, dtype=args.dtype, orders=args.orders)
    model.check()
    fitted, asked = default_verifier(), AskedVerifier(model)
    entries = [entry for entry in book().entries if held_out(book())["test"](entry)]
    # In the same order: the fitted one reads all pairs of an entry together.
    pairs, inputs = labelled(fitted, entries), labelled_pairs(fitted, entries, fitted.frequency, seed=1)
    found: dict[str, dict[str, Array]] = {"fitted": {}, model.name: {}}
    for kind, chosen in drawn(pairs, args.pairs).items():
        found["fitted"][kind] = inputs.of[kind][chosen] @ fitted.head[:-1]
        parts = []
        for start in range(0, len(chosen), _PART):
            parts.append(asked.of_pairs([pairs[kind][k] for k in chosen[start : start + _PART]]))
            sys.stderr.write(f"{kind} {start + len(parts[-1])} of {len(chosen)}\n")
        found[model.name][kind] = np.concatenate(parts)
    told = {name: figures(scores) for name, scores in found.items()}
    print(json.dumps({"pairs": {kind: len(own) for kind, own in found["fitted"].items()}, **told}))  # noqa: T201
