"""What the second hop brings on the habit book: ``python -m models.nets.measure_composition``.

Households draw most of their categories among those that can be anchors themselves, so that things do lie by things
that were moved; each target's places are followed to where their movable anchors are. Measured is the mass by anchors
that stay, with the second hop and without, at habit level ``full``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence

import numpy as np

from models.nets.head_reader import HeadReader
from ucon.core.errors import ConfigError, UconError
from ucon.core.rng import stream
from ucon.habits.book import book
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.splits import entry_parts
from ucon.retrieval.compose import compose
from ucon.retrieval.sampling import anchor_distribution

FIRST_SEED = 10_000


def household(seed: int, k: int = 20) -> KnowledgeBase:
    """Test entries of ``k`` categories, three quarters of them categories that other things are placed by."""
    data, parts, rng = book(), entry_parts(book()), stream(seed, "composition")
    usable = {name: [e for e in data.entries_of(name) if parts[e.id] == "test"] for name in data.categories}
    names = [name for name, entries in usable.items() if entries]
    movable = [name for name in names if name in data.anchors]
    chosen = list(rng.permutation(movable)[: 3 * k // 4])
    chosen += list(rng.permutation([name for name in names if name not in movable])[: k - len(chosen)])
    drawn = {str(n): [usable[str(n)][int(rng.integers(len(usable[str(n)])))]] for n in chosen}
    return KnowledgeBase.build(data, drawn, seed, "task")


def followed(reader: HeadReader, kb: KnowledgeBase, target: str, names: Sequence[str], depth: int) -> dict[str, float]:
    """Belief about a target at level full, its movable anchors followed."""

    def beliefs(anchors: Sequence[str]) -> list[Mapping[str, float]]:
        readings = reader.read_all(list(anchors), kb.texts)
        return [dict(zip(names, reading.belief(names).p, strict=True)) for reading in readings]

    belief = reader.read(target, kb.texts).belief(names)
    return compose(target, dict(zip(names, belief.p, strict=True)), kb.entries, beliefs, depth)


def truth(kb: KnowledgeBase, target: str) -> dict[str, float]:
    """Where the target is in the end, as its entries and those of its anchors say."""
    own = {name: anchor_distribution(entries) for name, entries in kb.entries.items()}
    return compose(target, own[target], own, lambda names: [own[name] for name in names], least=0.0)


def main(words: Sequence[str] | None = None) -> None:
    """Print hit@5 and NLL without and with the second hop, over targets that need it and over all."""
    parser = argparse.ArgumentParser(prog="models.nets.measure_composition", description="Measure the second hop.")
    parser.add_argument("--run", metavar="RUN", help="a run of learner=belief; default: the shipped head")
    parser.add_argument("--kbs", type=int, default=10, help="knowledge bases")
    args = parser.parse_args(words)
    if args.kbs < 1:
        raise ConfigError(f"--kbs {args.kbs}: expected a number of knowledge bases from 1 up")
    reader, names = HeadReader.load(args.run), book().anchors
    rows: dict[int, list[tuple[float, float, float]]] = {0: [], 3: []}
    for number in range(args.kbs):
        kb = household(FIRST_SEED + number)
        for target, entries in kb.entries.items():
            chained = sum(p for name, p in anchor_distribution(entries).items() if name in kb.entries)
            y = truth(kb, target)
            for depth, found in rows.items():
                p = followed(reader, kb, target, names, depth)
                best = sorted(p, key=lambda name: -p[name])[:5]
                nll = -sum(v * np.log(max(p.get(name, 0.0), 1e-4)) for name, v in y.items())
                found.append((chained, sum(y.get(name, 0.0) for name in best), float(nll)))
    for depth, found in rows.items():
        table = np.asarray(found)
        for label, chosen in (("chained", table[:, 0] > 0), ("all", table[:, 0] >= 0)):
            hit, nll = table[chosen, 1:].mean(0)
            print(f"depth {depth} {label:8s} n={chosen.sum()} hit_at_5 {hit:.3f} nll {nll:.3f}")  # noqa: T201


if __name__ == "__main__":
    try:
        main()
    except UconError as error:
        sys.exit(f"error: {error}")
