"""Measures the belief head or the fitted reader on held-out habits: ``python -m ucon data measure-head``.

On the habit book: households of 20 test categories, all anchors of the book as candidates, in mode ``task`` (one entry
per category, about 200 habits) and ``category`` (all entries). On the official release (``--official FOLDER``):
held-out (scene, category) pairs, with all categories of the scene as candidates.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from models.nets.belief.head_reader import HeadReader
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.beliefs import ORACLE, Measured, Reader, measure_beliefs
from ucon.habits.book import book
from ucon.habits.knowledge import MODES, KnowledgeBase
from ucon.habits.official import official
from ucon.habits.release import STANDING_FILE
from ucon.habits.splits import entry_parts
from ucon.objects.catalogue import catalogue
from ucon.readers.anchor_prior import scene_anchors
from ucon.readers.anchor_reader import AnchorReader
from ucon.readers.sampled_homes import entry_kb, sampled_kb
from ucon.retrieval.dense import DenseRetriever

#: First seed of measurements; training and validation use other seeds.
FIRST_SEED = 10_000


def on_the_book(reader: Reader, part: str, mode: str, n_kbs: int, whole: bool = True) -> dict[str, Measured]:
    """Measure on households of the habit book.

    Args:
        reader: reads the habits.
        part: ``val`` or ``test``; nothing was trained on these categories.
        mode: ``task`` or ``category``.
        n_kbs: number of households.
        whole: whether the retriever embeds whole sentences.

    Returns:
        Measures by habit level.
    """
    data = book()
    kbs = [sampled_kb(data, part, FIRST_SEED + number, mode) for number in range(n_kbs)]  # type: ignore[arg-type]
    return measure_beliefs(kbs, reader, DenseRetriever(whole=whole), lambda _: data.anchors)


def on_the_release(reader: Reader, folder: Path, part: str) -> dict[str, Measured]:
    """Measure on every entry of the release's held-out (scene, category) pairs, once each.

    Candidates are all categories that stand in the scene.

    Args:
        reader: reads the habits.
        folder: of the official release.
        part: ``val`` or ``test``.

    Raises:
        DataError: the list of what stands in the scenes is missing.
    """
    data = official(folder, catalogue().names)[0]
    if not data.standing:
        raise DataError(f"{folder}: no {STANDING_FILE} of these scenes, which says what may be a place")
    parts, named = entry_parts(data), scene_anchors(data.entries)
    kbs = [entry_kb(data, entry, FIRST_SEED) for entry in data.entries if parts[entry.id] == part]

    def candidates(kb: KnowledgeBase) -> Sequence[str]:
        scene = next(iter(kb.entries.values()))[0].scene or ""
        return sorted(named[scene] | set(data.standing.get(scene, ())))

    return measure_beliefs(kbs, reader, DenseRetriever(whole=False), candidates, lambda entry: parts[entry.id] == part)


def lines(found: dict[str, Measured]) -> list[str]:
    """One line of text per habit level, with intervals."""
    out = []
    for level, measured in found.items():
        cells = [f"{name} {i.mean:.3f} [{i.low:.3f}, {i.high:.3f}]" for name, i in measured.intervals().items()]
        error = "" if level == ORACLE else f"  ece {measured.calibration_error:.4f}"
        out.append(f"{level:10s} n={len(measured.clusters)}  " + "  ".join(cells) + error)
    return out


def as_json(found: dict[str, Measured]) -> dict[str, dict[str, object]]:
    """The same figures as plain values: (mean, low, high) by name and level."""
    return {
        level: {name: [round(v, 4) for v in (i.mean, *i.ci95)] for name, i in measured.intervals().items()}
        | {"ece": round(measured.calibration_error, 4), "n": len(measured.clusters)}
        for level, measured in found.items()
    }


def main(words: Sequence[str]) -> None:
    """Run the command: print a line per habit level, or JSON.

    Args:
        words: of the command line.

    Raises:
        ConfigError: ``--kbs`` below 1.
        DataError: files of the head or the release are missing or damaged.
    """
    parser = argparse.ArgumentParser(prog="ucon data measure-head", description="Measure beliefs on held-out habits.")
    parser.add_argument("--run", metavar="RUN", help="a run of learner=belief; default: the shipped head")
    parser.add_argument("--fitted", action="store_true", help="the fitted reader instead of a head")
    parser.add_argument("--official", metavar="FOLDER", help="the official release; default: the habit book")
    parser.add_argument("--part", choices=("val", "test"), default="test")
    parser.add_argument("--mode", choices=MODES, action="append", help="of the book's knowledge bases; default: both")
    parser.add_argument("--kbs", type=int, default=20, help="knowledge bases of the book")
    parser.add_argument("--json", action="store_true", help="print JSON")
    args = parser.parse_args(words)
    if args.kbs < 1:
        raise ConfigError(f"--kbs {args.kbs}: expected a number of knowledge bases from 1 up")
    reader: Reader = AnchorReader() if args.fitted else HeadReader.load(args.run)
    if args.official:
        runs = {"official": partial(on_the_release, reader, Path(args.official), args.part)}
    else:
        runs = {mode: partial(on_the_book, reader, args.part, mode, args.kbs) for mode in args.mode or MODES}
    found = {name: run() for name, run in runs.items()}
    if args.json:
        print(json.dumps({name: as_json(rows) for name, rows in found.items()}, indent=1))  # noqa: T201
        return
    for name, rows in found.items():
        print("\n".join(f"{name:9s} {line}" for line in lines(rows)))  # noqa: T201
