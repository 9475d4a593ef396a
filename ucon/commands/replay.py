"""``python -m ucon replay RUN ...``: plays finished runs again and reports whether their numbers are reproduced."""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ucon.configuration.kept_config import add_places, bad, configuration_of, places_in

if TYPE_CHECKING:
    from ucon.evaluation.kept.replayed import ReplayResult


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("runs", nargs="+", metavar="RUN", type=Path, help="run folders of eval.py, or of results/")
    parser.add_argument("--every", type=int, default=1, metavar="K", help="play only every K-th episode (default: all)")
    add_places(parser)
    parser.add_argument(
        "--device",
        help="device of all networks, such as cpu for a run made on a GPU; on another device than the stored one, some "
        "episodes may differ (default: as stored)",
    )
    parser.add_argument("--workers", default="auto", help="processes (default: one per core); results stay the same")
    parser.add_argument("--out", type=Path, default=Path("runs/replay"), help="folder of the new runs (runs/replay)")
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")


def run(args: argparse.Namespace) -> int:
    """Play each run again, and print a line for each.

    Args:
        args: parsed options.

    Returns:
        Exit code 0 if all runs are reproduced, 1 if one differs or could not be played.

    Raises:
        ConfigError: a wrong option.
    """
    from hydra.errors import HydraException

    from ucon.configuration.stored import said_in
    from ucon.core.device import NO_GPU, torch_device
    from ucon.core.errors import UconError
    from ucon.evaluation.playing.crew import WorkerError

    if args.every < 1:
        raise bad("--every", str(args.every), "a whole number from 1 up")
    places, said = places_in(args), said_in(args)
    device = None if args.device is None else torch_device(args.device, "--device")
    ok = True
    for folder in args.runs:
        out = args.out / folder.resolve().name
        try:
            config = configuration_of(folder, places, said)
            if device is not None:
                config = _on_device(config, device)
            again = _replay(folder, out, args.every, config, args.workers)
        except (UconError, HydraException, WorkerError) as error:
            ok = False
            # A WorkerError is a bug and keeps its traceback; other errors are printed as one line.
            why = str(error) if isinstance(error, WorkerError) else " ".join(str(error).split())
            if NO_GPU in why and device is None:
                why = f"{why.partition(';')[0]}; replay --device cpu plays it here"
            print(f"{folder}: not played: {why}", file=sys.stderr, flush=True)
        else:
            ok = ok and again.found.same
            print(json.dumps(again.to_json(folder)) if args.json else f"{folder}: {_line(again)}", flush=True)
    return 0 if ok else 1


class _Again(NamedTuple):
    """Result of playing a run again."""

    found: ReplayResult
    n_new: int
    """Number of episodes played by this call; the others were played before an interruption."""
    out: Path

    def to_json(self, folder: Path) -> dict[str, Any]:
        """Plain values for ``--json``."""
        new = {"run": str(folder), "out": str(self.out), "played": self.n_new, "same": self.found.same}
        return new | asdict(self.found)


def _replay(folder: Path, out: Path, every: int, config: dict[str, Any], workers: str) -> _Again:
    from ucon.core.output import stdout_to_stderr
    from ucon.evaluation.kept.record import read_records
    from ucon.evaluation.kept.replayed import StoredRun, replayed
    from ucon.programs.evaluating import Evaluation

    kept = StoredRun.read(folder)
    limit = config["limit"]
    config |= {
        "every": config["every"] * every,
        "limit": None if limit is None else math.ceil(limit / every),
        "workers": int(workers) if workers.isdecimal() else workers,
        "pictures": 0,
        "progress": True,
    }
    with stdout_to_stderr():
        run = Evaluation(config, out, anew=True)
        kept.check([episode.id for episode in run.episodes], every)
        run.play()
    return _Again(replayed(kept, read_records(run.out), every), run.n_new, run.out)


def _on_device(config: Any, device: str) -> Any:
    """A configuration all of whose parts run on one device."""
    if isinstance(config, list):
        return [_on_device(part, device) for part in config]
    if not isinstance(config, dict):
        return config
    return {name: device if name == "device" else _on_device(part, device) for name, part in config.items()}


def _line(again: _Again) -> str:
    """One line of text about the result."""
    found, earlier = again.found, again.found.n - again.n_new
    what = f"{found.label}, {found.n} episodes played" + (f" ({earlier} before an interruption)" if earlier else "")
    if found.same:
        return f"{what}: the same {'to the byte' if found.by == 'episodes' else 'in every figure'}"
    sr, spl = ((found.kept[name], found.now[name]) for name in ("success_rate", "spl"))
    some = ", ".join(found.differing[:3])
    more = ", ..." if len(found.differing) > 3 else ""
    return (
        f"{what}: {len(found.differing)} {found.by} differ ({some}{more}); SR {100 * sr[0]:.1f} -> {100 * sr[1]:.1f}, "
        f"SPL {spl[0]:.3f} -> {spl[1]:.3f}; see {again.out}"
    )
