"""``python -m ucon replay RUN ...``: play finished runs again and say whether their numbers come out the same."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.evaluation.replayed import Replayed

#: Options that older configurations lack, at what they were then.
_LATER = {"limit": None, "every": 1, "batch": 1, "seed": 0}
_NEEDED = {"agent", "habit_level"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("runs", nargs="+", metavar="RUN", type=Path, help="folders of results/, or of eval.py")
    parser.add_argument(
        "--every", type=int, default=1, metavar="K", help="play every K-th of their episodes (default: all)"
    )
    parser.add_argument(
        "--path",
        action="append",
        default=[],
        metavar="OLD=NEW",
        help="where what a configuration names OLD lies here (runs/head1=FOLDER, PATH=FOLDER); may be given again",
    )
    parser.add_argument("--workers", default="auto", help="processes (default: one a core); changes nothing")
    parser.add_argument("--out", type=Path, default=Path("runs/replay"), help="folder of the new runs (runs/replay)")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Play each; 0 where all came out as they were kept, 1 where some did not or could not be played."""
    from ucon.core.errors import UconError

    if args.every < 1:
        raise _bad("--every", str(args.every), "a whole number from 1 up")
    places = dict(_place(word) for word in args.path)
    names = [folder.resolve().name for folder in args.runs]
    if len(set(names)) < len(names):
        raise _bad("RUN", " ".join(map(str, args.runs)), "folders of different names, since the new runs get them too")
    ok = True
    for folder, name in zip(args.runs, names, strict=True):
        try:
            found = _replay(folder, args.out / name, args.every, places, args.workers)
        except UconError as error:
            ok = False
            print(f"{folder}: not played: {error}", file=sys.stderr, flush=True)
            continue
        ok = ok and found.same
        line = json.dumps({"run": str(folder), "same": found.same} | asdict(found)) if args.json else _told(found)
        print(line if args.json else f"{folder}: {line}", flush=True)
    return 0 if ok else 1


def _bad(option: str, value: str, expected: str) -> Exception:
    from ucon.core.errors import ConfigError

    return ConfigError(f"{option} {value}: expected {expected}")


def _place(word: str) -> tuple[str, str]:
    old, sign, new = word.partition("=")
    if not (old and sign and new):
        raise _bad("--path", word, "OLD=NEW")
    return old.rstrip("/"), str(Path(new).expanduser())


def _replay(folder: Path, out: Path, every: int, places: Mapping[str, str], workers: str) -> Replayed:
    from ucon.commands.evaluating import Evaluation
    from ucon.commands.output import stdout_to_stderr
    from ucon.core.errors import DataError
    from ucon.evaluation.folder import read_config
    from ucon.evaluation.record import read_records
    from ucon.evaluation.replayed import Kept, replayed

    kept, config = Kept.read(folder), {**_LATER, **_moved(read_config(folder), places)}
    if missing := sorted(_NEEDED - config.keys()):
        raise DataError(f"{folder}: its configuration lacks {', '.join(missing)}; restore it or evaluate again")
    limit = config["limit"]
    config |= {
        "out": str(out),
        "every": config["every"] * every,
        "limit": None if limit is None else math.ceil(limit / every),
        "workers": int(workers) if workers.isdecimal() else workers,
        "pictures": 0,
        "progress": sys.stderr.isatty(),
    }
    with stdout_to_stderr():
        Evaluation(config, out).play()
    return replayed(kept, read_records(out), every)


def _moved(value: Any, places: Mapping[str, str]) -> Any:
    """A configuration whose paths begin where they lie here."""
    if isinstance(value, dict):
        return {name: _moved(inner, places) for name, inner in value.items()}
    if isinstance(value, list):
        return [_moved(inner, places) for inner in value]
    if isinstance(value, str):
        for old, new in places.items():
            if value == old or value.startswith(f"{old}/"):
                return new + value[len(old) :]
    return value


def _told(found: Replayed) -> str:
    """One line for a person."""
    what = f"{found.label}, {found.n} episodes"
    if found.same:
        return f"{what}: the same {'to the byte' if found.by == 'episodes' else 'in every figure'}"
    sr, spl = ((found.kept[name], found.now[name]) for name in ("success_rate", "spl"))
    some = ", ".join(found.differing[:3])
    more = ", ..." if len(found.differing) > 3 else ""
    return (
        f"{what}: {len(found.differing)} {found.by} differ ({some}{more}); SR {100 * sr[0]:.1f} -> {100 * sr[1]:.1f}, "
        f"SPL {spl[0]:.3f} -> {spl[1]:.3f}"
    )
