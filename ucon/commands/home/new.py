"""``python -m ucon home new FILE.yaml``: writes the worked example, to be edited into your own home."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("file", type=Path, metavar="FILE.yaml", help="file to write; an existing file is left alone")


def run(args: argparse.Namespace) -> int:
    """Write the example.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: the name has another ending, or the file exists.
    """
    from ucon.core.errors import ConfigError
    from ucon.core.files import write_atomic
    from ucon.envs.own_home import EXAMPLE, is_home_file

    if not is_home_file(args.file):
        raise ConfigError(f"{args.file}: expected a name that ends in .yaml")
    if args.file.exists():
        raise ConfigError(f"{args.file}: exists already; give another name, or remove it")
    write_atomic(args.file, EXAMPLE.read_bytes())
    print(f"{args.file}: a flat of two rooms, three sentences and one lost mug; change what you like, then")
    print(f"  python -m ucon home check {args.file}")
    sys.stdout.flush()
    return 0
