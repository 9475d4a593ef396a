"""Measures retrievers on held-out entries: ``python -m ucon data measure-retrieval --help``.

Knowledge bases hold one entry for each of 20 categories. On the habit book: test categories (never trained on), and
test entries of all categories. On the official release: held-out (scene, category) pairs among other habits of their
scene; pairs whose category is in no train entry are also reported separately.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from ucon.core.errors import ConfigError
from ucon.fitting.measures import Row, measure_retrieval
from ucon.habits.book import book
from ucon.habits.official import official
from ucon.habits.splits import Split, entry_parts
from ucon.habits.types import Entry, HabitDataset
from ucon.objects.catalogue import catalogue
from ucon.readers.sampled_homes import part_kb, sampled_kb
from ucon.retrieval.base import Retriever
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.tuned import tuned_encoder

#: First seed of measurements; training and validation use other seeds.
FIRST_SEED = 10_000


def held_out(data: HabitDataset, retriever: Retriever, part: Split = "test", n_kbs: int = 20) -> dict[str, Row]:
    """Figures of a retriever by kind of target, with the mean size ``n`` of the knowledge bases.

    Args:
        data: the dataset.
        retriever: what is measured.
        part: ``val`` or ``test``.
        n_kbs: number of knowledge bases.

    Raises:
        ConfigError: ``n_kbs`` below 1.
        DataError: the dataset has no entry in that part.
    """
    if n_kbs < 1:
        raise ConfigError(f"--kbs {n_kbs}: expected a number of knowledge bases from 1 up")
    parts = entry_parts(data)
    learned = {e.category for e in data.entries if parts[e.id] == "train"}

    def of_part(entry: Entry) -> bool:
        return parts[entry.id] == part

    def unseen(entry: Entry) -> bool:
        return of_part(entry) and entry.category not in learned

    kbs = [part_kb(data, part, FIRST_SEED + number) for number in range(n_kbs)]
    rows = {f"{part} entries": measure_retrieval(kbs, retriever, of_part)}
    if not data.scenes:
        kbs = [sampled_kb(data, part, FIRST_SEED + number, "task") for number in range(n_kbs)]
        rows[f"{part} categories"] = measure_retrieval(kbs, retriever)
    elif any(unseen(entry) for kb in kbs for entries in kb.entries.values() for entry in entries):
        rows["unseen categories"] = measure_retrieval(kbs, retriever, unseen)
    size = round(sum(map(len, kbs)) / n_kbs, 1)
    return {name: row | {"n": size} for name, row in rows.items()}


def main(words: Sequence[str]) -> None:
    """Run the command: print a line per kind of target, or JSON.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(
        prog="ucon data measure-retrieval", description="Measure retrieval on held-out habits."
    )
    parser.add_argument("--tuned", nargs="?", const="", metavar="RUN", help="the shipped adapter, or that of a run")
    parser.add_argument("--official", metavar="FILE", help="task file of the official release; default: the habit book")
    parser.add_argument("--part", choices=("val", "test"), default="test")
    parser.add_argument("--kbs", type=int, default=20, help="knowledge bases")
    parser.add_argument("--json", action="store_true", help="print JSON")
    args = parser.parse_args(words)
    data = official(Path(args.official), catalogue().names)[0] if args.official else book()
    encoder = None if args.tuned is None else tuned_encoder(args.tuned or None)
    retriever = DenseRetriever(encoder, whole=False)
    found = held_out(data, retriever, args.part, args.kbs)
    lines = [f"{name:18s} " + "  ".join(f"{k} {v:g}" for k, v in row.items()) for name, row in found.items()]
    print(json.dumps(found, indent=1) if args.json else "\n".join(lines))  # noqa: T201
