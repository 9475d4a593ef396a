"""``python -m ucon pack``: compiled homes as small files, so that they load anywhere without PyBullet."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("homes", nargs="*", metavar="HOME", help="names of homes; default: those of the sets given")
    parser.add_argument(
        "--episodes", action="append", metavar="SET", help="pack the homes of this set (default: mini); may be repeated"
    )
    parser.add_argument("--out", type=Path, help="folder; default: the package's own")


def run(args: argparse.Namespace) -> int:
    """Build and write the homes."""
    from ucon.commands.output import stdout_to_stderr
    from ucon.sim.cache import PACKED, pack_homes
    from ucon.task.sets import load_episodes

    homes = list(args.homes)
    if not homes:
        sets = args.episodes or ["mini"]
        homes = sorted({episode.scene for name in sets for episode in load_episodes(name)})
    with stdout_to_stderr():
        paths = pack_homes(homes, args.out or PACKED)
    sizes = [path.stat().st_size / 1024 for path in paths]
    print(f"{len(paths)} homes in {args.out or PACKED}: {sum(sizes):.0f} KB, the largest {max(sizes):.0f} KB")
    return 0
