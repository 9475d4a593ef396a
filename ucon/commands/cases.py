"""``python -m ucon cases RUN``: which habit caused a search's outcome, found by playing it again without that habit."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ucon.commands.home import case_figure
from ucon.configuration.kept_config import add_places, bad, configuration_of, places_in

if TYPE_CHECKING:
    from ucon.programs.counterfactual import Found

#: Number of examples that are printed of each kind.
_SHOWN = 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    case_figure.add_arguments(parser)
    parser.add_argument(
        "run", nargs="?", metavar="RUN", type=Path, help="run folder of eval.py, or of results/, at a level with habits"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("runs/cases"), help="folder for all searches played (runs/cases)"
    )
    parser.add_argument(
        "--most", type=int, default=5, metavar="N", help="habits to try in each episode, by weight (default: 5)"
    )
    parser.add_argument(
        "--about",
        action="append",
        default=[],
        choices=("target", "beside", "anchor", "other"),
        help="try habits about the target, about a thing that stands next to it where the habit says, about a thing "
        "that may be kept at the target's anchor, or about any other thing; may be repeated (default: all)",
    )
    parser.add_argument("--every", type=int, default=1, metavar="K", help="try only every K-th episode (default: all)")
    parser.add_argument("--workers", default="auto", help="processes (default: one per core); results stay the same")
    add_places(parser)
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object per line: habits tried, then figures"
    )


def run(args: argparse.Namespace) -> int:
    """Play the counterfactuals that are missing, and print the causes.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: a wrong option, or a run without habits.
        DataError: a run that cannot be read.
    """
    from ucon.configuration.stored import said_in
    from ucon.core.errors import ConfigError
    from ucon.core.output import stdout_to_stderr
    from ucon.evaluation.causes.causes import ABOUT
    from ucon.programs.counterfactual import Counterfactuals

    if args.figure is not None:
        return case_figure.run(args)
    if args.run is None:
        raise ConfigError("RUN: expected the folder of a run, or --figure")
    for option in ("most", "every"):
        if getattr(args, option) < 1:
            raise bad(f"--{option}", str(getattr(args, option)), "a whole number from 1 up")
    config = configuration_of(args.run, places_in(args), said_in(args))
    config |= {
        "every": config["every"] * args.every,
        "workers": int(args.workers) if args.workers.isdecimal() else args.workers,
        "progress": True,
    }
    with stdout_to_stderr():
        found = Counterfactuals(config, args.out, args.most, args.about or ABOUT).play()
    if args.json:
        for one in found.tried:
            print(json.dumps(one.to_json()))
        print(json.dumps({"episodes": found.episodes, "told": found.told, "counts": found.counts}))
    else:
        _print(found, args.out)
    return 0


def _print(found: Found, out: Path) -> None:
    from ucon.core.output import wide_console
    from ucon.evaluation.causes.causes import ABOUT, strongest

    wide_console().print(_table(found.counts))
    causes = strongest(found.tried).values()
    for kind in ABOUT:
        best = sorted(
            (one for one in causes if one.about == kind and one.helps), key=lambda one: one.gain, reverse=True
        )
        for one in best[:_SHOWN]:
            with_it, without = (
                f"found in {steps} steps" if success else "not found"
                for success, steps in zip(one.success, one.steps, strict=True)
            )
            print(f"{one.episode} ({one.scene}): {one.target.replace('_', ' ')}; habit {one.rank}, about: {kind}")
            print(f"  {one.habit}")
            print(f"  with it {with_it}, without it {without}")
    print(f"{len(found.tried)} of {found.told} habits tried in {found.episodes} episodes; {len(causes)} have a cause")
    if causes:
        print(f"to see a pair: python -m ucon watch {out}/pairs/told EPISODE, and the same with {out}/pairs/removed")


def _table(counts: Mapping[str, Mapping[str, Any]]) -> Any:
    from rich.table import Table

    columns = ("habit about", "tried", "search changes", "helps % [95 %]", "hurts % [95 %]", "helps less hurts",
               "found with it alone", "lost with it alone", "confirmed helps", "confirmed hurts")  # fmt: skip
    table = Table(*columns)
    for kind, one in counts.items():
        if not one["tried"]:
            continue
        helps, hurts = one["confirmed_helps"], one["confirmed_hurts"]
        table.add_row(
            kind, str(one["tried"]), str(one["changes_search"]),
            *(_percent(one[side]) for side in ("helps", "hurts", "helps_less_hurts")),
            str(one["found_with_it_alone"]), str(one["lost_with_it_alone"]),
            f"{helps['confirmed']} of {helps['of']}", f"{hurts['confirmed']} of {hurts['of']}",
        )  # fmt: skip
    return table


def _percent(share: Mapping[str, Any]) -> str:
    low, high = share["ci95"]
    return f"{100 * share['share']:.1f} [{100 * low:.1f}, {100 * high:.1f}]"
