"""``python -m ucon compare RUN RUN``: paired differences with intervals on the episodes that both runs played."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.evaluation.figures.markdown import Run
    from ucon.evaluation.figures.paired import Comparison
    from ucon.evaluation.kept.record import EpisodeRecord


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument(
        "runs", nargs="+", metavar="RUN", type=Path, help="run folders (two or more); A+B joins two runs of one agent"
    )
    parser.add_argument(
        "--against",
        action="append",
        default=[],
        metavar="RUN",
        type=Path,
        help="compare every RUN with this one only; may be repeated (default: every pair)",
    )
    parser.add_argument(
        "--closed",
        nargs=2,
        metavar=("START", "GOAL"),
        type=Path,
        help="show how much of the distance from START (frontier) to GOAL (oracle_locations) every RUN has closed, and "
        "how much carries over to unseen categories and scenes; with --markdown or --json",
    )
    parser.add_argument(
        "--by-kind", action="store_true", help="also within each kind of home: generated flats, scenes, ..."
    )
    parser.add_argument(
        "--when",
        action="store_true",
        help="also within groups in which habits may help more or less: by how much households differ in where they "
        "keep the target, by whether its place is against common sense, by size of home; with --markdown or --json",
    )
    parser.add_argument(
        "--by-scene", action="store_true", help="resample whole homes in the bootstrap (wider intervals)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--plot",
        metavar="FOLDER",
        type=Path,
        help="also draw PNG files: SR over steps, runs ordered by result, differences by subset, when habits pay, and "
        "success by share of false sentences; for runs of train.py, their learning curves",
    )
    parser.add_argument("--markdown", action="store_true", help="print the tables of a results page, also by home size")


def run(args: argparse.Namespace) -> int:
    """Print the paired differences of runs, the first minus the second.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: fewer than two runs, or runs without a common episode.
        DataError: a run that cannot be read.
    """
    from ucon.core.errors import ConfigError
    from ucon.core.output import wide_console
    from ucon.evaluation.figures.groups import PAYS, names_of
    from ucon.evaluation.figures.markdown import kind_of_home, markdown_page, read_runs
    from ucon.evaluation.figures.paired import compare_records, comparison_table
    from ucon.evaluation.figures.plotting import require_matplotlib
    from ucon.evaluation.figures.run_plots import plot_runs

    _check_shown(args)
    folders = list(dict.fromkeys([*args.runs, *args.against, *(args.closed or ())]))
    if _are_trained(folders, args):
        return _plot_training(folders, args.plot)
    if args.plot is not None:
        require_matplotlib()
    if len(folders) < 2:
        raise ConfigError(f"compare needs at least two run folders, got {len(folders)}")
    runs = read_runs(folders)
    wanted = [(a, b) for b in args.against for a in args.runs if a != b] or list(combinations(folders, 2))

    def compared(among: Callable[[EpisodeRecord], bool] = lambda _: True) -> list[Comparison]:
        """All comparisons, over some of the episodes or over all."""
        chosen = {f: [r for r in run.records if among(r)] for f, run in runs.items()}
        return [
            compare_records(
                chosen[a],
                chosen[b],
                (str(a), str(b)) if args.json else (runs[a].label, runs[b].label),
                by_scene=args.by_scene,
            )
            for a, b in wanted
        ]

    pairs = compared()
    if args.plot is not None:
        drawn = plot_runs(list(runs.values()), [(runs[a], runs[b]) for a, b in wanted], args.plot)
        for path in [*drawn, *_plot_shares(runs, args.plot)]:
            print(path, file=sys.stderr)

    def within(group: Callable[[EpisodeRecord], str]) -> dict[str, list[Comparison]]:
        """All comparisons within each group that all runs have."""
        return {
            name: compared(lambda r, name=name: group(r) == name)  # type: ignore[misc]
            for name in names_of(group, [run.records for run in runs.values()])
        }

    kinds = within(lambda r: kind_of_home(r.scene)) if args.by_kind else None
    asked = PAYS if args.when else {}
    groups = {f"{title}: {name}": found for title, of in asked.items() for name, found in within(of).items()} or None
    way = (runs[args.closed[0]], runs[args.closed[1]]) if args.closed else None
    if args.json:
        print(json.dumps(_json(pairs, runs, way, {"kinds": kinds, "groups": groups}), indent=1))
    elif args.markdown:
        print(markdown_page(list(runs.values()), pairs, way, kinds, groups))
    else:
        wide_console().print(comparison_table(pairs))
        for kind, among in (kinds or {}).items():
            wide_console().print(comparison_table(among, ("success_rate", "spl"), title=kind))
    return 0


def _plot_shares(runs: Mapping[Path, Run], plot: Path) -> list[Path]:
    """Draw success against the share of false sentences, where runs have some; returns the files written."""
    from ucon.evaluation.figures.false_shares import draw_false_shares, false_shares

    lines = false_shares(runs)
    if lines:
        draw_false_shares(lines, plot / "false_shares.png")
    return [plot / "false_shares.png"] if lines else []


def _check_shown(args: argparse.Namespace) -> None:
    """Raise :class:`ConfigError` for an option that the chosen form of output does not show."""
    from ucon.core.errors import ConfigError

    for option in ("closed", "when"):
        if getattr(args, option) and not (args.json or args.markdown):
            raise ConfigError(f"--{option} is shown only with --markdown or --json; give one of them")


def _are_trained(folders: list[Path], args: argparse.Namespace) -> bool:
    """Whether the folders are runs of ``train.py``, which are compared only by their learning curves."""
    from ucon.core.errors import ConfigError
    from ucon.learning.run.run_folder import METRICS

    trained = [folder for folder in folders if (folder / METRICS).is_file()]
    if 0 < len(trained) < len(folders):
        raise ConfigError(f"{trained[0]}: a run of train.py; compare it with other runs of train.py only")
    if trained and (args.plot is None or args.json or args.markdown or args.closed or args.by_kind):
        raise ConfigError("runs of train.py are compared by their learning curves; give --plot FOLDER alone")
    return bool(trained)


def _plot_training(folders: list[Path], plot: Path) -> int:
    """Draw the learning curves of runs of ``train.py``."""
    from ucon.evaluation.figures.plotting import require_matplotlib
    from ucon.learning.run.learning_curve import draw_curves

    require_matplotlib()
    plot.mkdir(parents=True, exist_ok=True)
    draw_curves(folders, plot / "learning_curves.png")
    print(plot / "learning_curves.png")
    return 0


def _json(
    pairs: list[Comparison],
    runs: dict[Path, Run],
    way: tuple[Run, Run] | None,
    parts: Mapping[str, Mapping[str, list[Comparison]] | None],
) -> Any:
    """The list of differences; or with ``way`` or ``parts``, a mapping with distance closed by run, and the parts."""
    from ucon.evaluation.figures.gap_closed import carried_over, distance_closed

    differences = [pair.to_json() for pair in pairs]
    if way is None and not any(parts.values()):
        return differences
    found: dict[str, Any] = {"differences": differences}
    for name, part in parts.items():
        if part is not None:
            found[name] = {group: [pair.to_json() for pair in among] for group, among in part.items()}
    if way is None:
        return found
    start, goal = way
    shares = {
        str(folder): {
            "closed": _plain_values(distance_closed(run.records, start.records, goal.records)),
            "carried_over": _plain_values(carried_over(run.records, goal.records)),
        }
        for folder, run in runs.items()
    }
    return found | {"from": start.label, "to": goal.label, "runs": shares}


def _plain_values(shares: Mapping[str, Any]) -> dict[str, Any]:
    """Dataclasses of numbers by name as plain values; NaN becomes null."""

    def known(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: known(inner) for name, inner in value.items()}
        return None if value != value else value

    return {name: known(asdict(share)) for name, share in shares.items()}
