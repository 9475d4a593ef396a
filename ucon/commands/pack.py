"""``python -m ucon pack``: packs episode sets and their homes into small files that load without PyBullet."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument(
        "names", nargs="*", metavar="SET_OR_HOME", help="episode sets, homes, or home files (default: mini)"
    )
    parser.add_argument("--episodes", action="append", metavar="SET", help="a set by name or file; may be repeated")
    parser.add_argument(
        "--out", type=Path, help="folder for UCON_PACK on the other machine; default: only homes, into the package"
    )


def run(args: argparse.Namespace) -> int:
    """Write the homes and, with ``--out``, the sets.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: an unknown set or home.
    """
    from ucon.core.errors import ConfigError, unknown_name
    from ucon.core.output import stdout_to_stderr
    from ucon.envs.own_home import is_home_file, keep_set, own_set
    from ucon.scenes.library import SCENES, is_home_name
    from ucon.sim import cache
    from ucon.task import sets
    from ucon.task.own_home.shipped import home_path

    named = sets.episode_sets()
    wanted = [*(args.episodes or ()), *(name for name in args.names if name in named)]
    own = [Path(name) for name in args.names if is_home_file(name)]
    homes = [name for name in args.names if name not in named and not is_home_file(name)]
    for name in homes:
        if not is_home_name(name):
            raise ConfigError(unknown_name("set or home", name, [*named, *SCENES]))
    if own and not args.out:
        raise ConfigError(f"{own[0]}: a home file is packed into a folder; give --out FOLDER")
    if not args.names and not args.episodes:
        wanted = ["mini"]
    with stdout_to_stderr():
        files = sets.pack_sets(wanted, args.out / sets.IN_PACK) if args.out and wanted else []
        homes = sorted({*homes, *(e.scene for source in files or wanted for e in sets.load_episodes(source))})
        homes += [keep_set(own_set(home_path(file)), args.out) for file in own]
        folder = args.out / cache.IN_PACK if args.out else cache.PACKED
        paths = cache.pack_homes(homes, folder, fresh=args.out is None)
    sizes = [path.stat().st_size / 1024 for path in paths]
    print(f"{len(paths)} homes in {folder}: {sum(sizes):.0f} KB, the largest {max(sizes):.0f} KB")
    if args.out:
        print(f"{len(files)} episode files in {args.out / sets.IN_PACK}; use them with UCON_PACK={args.out}")
    return 0
