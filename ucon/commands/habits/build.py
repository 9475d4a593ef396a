"""``python -m ucon habits build``: makes the dataset file that everything else loads, from the book's text."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.generation.asked import AskedVerifier

_SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("--book", metavar="FOLDER", help="files in the habit book's format; default: the embedded book")
    parser.add_argument("--out", metavar="FILE", help="file to write; default, without --book: the shipped dataset")
    parser.add_argument("--work", metavar="FOLDER", help="folder for finished work; default: the user's cache")
    parser.add_argument("--doubts", metavar="FILE", help="write the labels that the verifier doubts, one per line")
    parser.add_argument(
        "--verifier",
        metavar="MODEL",
        help="a chat model on this machine that verifies in place of the fitted verifier: smollm2, or a folder",
    )
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2); the result stays the same")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Build the dataset, and print what was found.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: ``--book`` or ``--verifier`` without ``--out``, or a folder that does not exist.
        DataError: the model is missing, or the book breaks a rule of its format.
    """
    from ucon.configuration.wiring import existing
    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable, write_atomic
    from ucon.core.output import stdout_to_stderr
    from ucon.core.progress import Progress
    from ucon.generation.build import build
    from ucon.habits.book import BOOK_FILE, BOOK_FOLDER, CONTEXTS_FILE, CONTEXTS_FOLDER
    from ucon.habits.datafile import SUFFIX
    from ucon.language.store import write_manifest_of

    if args.book and not args.out:
        raise ConfigError("--book without --out: the shipped dataset is made from the embedded book; give --out FILE")
    if args.verifier and not args.out:
        raise ConfigError(
            "--verifier without --out: the shipped dataset is made with the fitted verifier; give --out FILE"
        )
    out = Path(args.out).expanduser() if args.out else BOOK_FILE
    book = existing(args.book, "--book") if args.book else BOOK_FOLDER
    doubts = Path(args.doubts).expanduser() if args.doubts else None
    if doubts:
        require_writable(doubts)
    verifier = _asked(args.verifier) if args.verifier else None
    with stdout_to_stderr(), ExitStack() as stack:
        steps: dict[str, Progress] = {}

        def show(step: str, done: int, total: int) -> None:
            if step not in steps:
                stack.close()  # ends the progress line of the previous step
                steps[step] = stack.enter_context(Progress(step, total))
            steps[step].update(done)

        built = build(
            out,
            book=book,
            work=Path(args.work).expanduser() if args.work else None,
            workers=args.workers,
            verifier=verifier,
            progress=show,
        )
    if (book.resolve(), out.resolve()) in ((BOOK_FOLDER, BOOK_FILE), (CONTEXTS_FOLDER, CONTEXTS_FILE)):
        for folder in {out.parent, book}:
            write_manifest_of(folder)
    if doubts:
        write_atomic(doubts, "".join(f"{doubt}\n" for doubt in built.doubts))
    figures = {"path": str(out), "bytes": out.stat().st_size, "sha256": built.dataset.sha256, **built.steps}
    lines = [str(doubt) for doubt in built.doubts]
    if args.json:
        print(json.dumps({**figures, "doubts": lines}, indent=1, ensure_ascii=False))
        return 0
    _print(figures, lines)
    sys.stderr.write(f"{out.name.removesuffix(SUFFIX)}: {len(built.dataset)} habits\n")
    return 0


def _asked(path: str) -> AskedVerifier:
    """A language model as verifier; a one-line error where it is missing."""
    from ucon.generation.asked import AskedVerifier
    from ucon.language.models.causal_lm import CausalModel

    model = CausalModel(path, dtype="bfloat16", orders=2)
    model.check()
    return AskedVerifier(model)


def _print(figures: dict[str, Any], doubts: Sequence[str]) -> None:
    for name, value in figures.items():
        print(f"{name:<10} {value}")
    if doubts:
        print("labels that the text does not support, for a person to check:")
    for line in doubts[:_SHOWN]:
        print(f"  {line}")
    if len(doubts) > _SHOWN:
        print(f"  ... and {len(doubts) - _SHOWN} more (--doubts FILE writes all)")
