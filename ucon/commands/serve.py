"""``python -m ucon serve``: serves pages to browsers on this machine alone: runs, homes, habits, play, study."""

from __future__ import annotations

import argparse
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument(
        "folders",
        nargs="*",
        metavar="FOLDER",
        type=Path,
        help="folders in which to look for runs (default: runs and results, if they exist)",
    )
    parser.add_argument("--port", type=int, help="0 for any free one (default 8765, or a free one if it is taken)")
    parser.add_argument(
        "--out", type=Path, default=Path("runs/serve"), help="folder for searches and answers (runs/serve)"
    )
    parser.add_argument("--habits", metavar="PATH", help="dataset file, task file or book folder; default: the book")
    parser.add_argument(
        "--home", metavar="FILE.yaml", type=Path, action="append", default=[], dest="homes",
        help="a home of your own, to search in on the page Play; may be repeated",
    )  # fmt: skip
    parser.add_argument("--no-browser", action="store_true", help="only print the address")


def run(args: argparse.Namespace) -> int:
    """Serve the pages until Ctrl-C.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: a wrong option, a port that is taken, or the extra ``serve`` is not installed.
        DataError: a damaged habit dataset, or faults of a home file.
    """
    from ucon.configuration.wiring import load_dataset
    from ucon.core.errors import ConfigError

    if args.port is not None and not 0 <= args.port <= 65535:
        raise ConfigError(f"--port {args.port}: expected 0 to 65535")
    if missing := [name for name in ("starlette", "uvicorn") if find_spec(name) is None]:
        raise ConfigError(f"{' and '.join(missing)} not installed; pip install 'ucon-nav[serve]'")
    if lost := next((folder for folder in args.folders if not folder.is_dir()), None):
        raise ConfigError(f"{lost}: no such folder; name folders with runs of eval.py or train.py in them")
    from ucon.envs.own_home import own_set, say_made
    from ucon.pages.serve.desk import Desk
    from ucon.pages.serve.play.games import named_homes
    from ucon.pages.serve.server import serve

    out = args.out.expanduser()
    _require_folder(out)
    folders = args.folders or [path for path in (Path("runs"), Path("results")) if path.is_dir()]
    homes = named_homes(args.homes)
    for file in args.homes:
        say_made(file, own_set(file))
    shown = tuple(folder.resolve() for folder in [*folders, out])
    desk = Desk(out.resolve(), shown, load_dataset(args.habits), homes)

    def ready(address: str) -> None:
        print(
            f"{address}\nonly this machine can open it; Ctrl-C ends it; searches and answers are kept",
            flush=True,
        )
        if not args.no_browser:
            _open(address)

    with suppress(KeyboardInterrupt):  # not raised in a job of a shell script, which ignores Ctrl-C
        serve(desk, args.port, ready)
    print("\nended; the same command continues", flush=True)
    return 0


def _require_folder(out: Path) -> None:
    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable

    if out.exists() and not out.is_dir():
        raise ConfigError(f"--out {out}: a file, expected a folder")
    require_writable(out / "play" / "anything")


def _open(address: str) -> None:
    """Open the address in the user's browser, once the server answers; only where there is a screen."""
    import os
    import sys
    import threading
    import webbrowser

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return  # a browser in the terminal would take over the terminal

    threading.Timer(0.7, webbrowser.open, (address,)).start()
