"""``python -m ucon cases --figure``: plays the two cases of the shipped homes, and draws each as a figure."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--figure`` and its options to the parser of ``cases``."""
    figure = parser.add_argument_group("draw the two cases of the shipped homes, instead of reading a run")
    figure.add_argument(
        "--figure", nargs="?", const=Path("runs/cases_shown"), type=Path, metavar="FOLDER",
        help="play case_book and case_newspaper without and with habits, and draw each (runs/cases_shown)",
    )  # fmt: skip
    figure.add_argument("--agent", default="belief", help="agent that searches, a file in configs/agent/ (belief)")
    figure.add_argument(
        "--task", default="real_robot", help="rules of the search, a file in configs/task/ (real_robot)"
    )


def run(args: argparse.Namespace) -> int:
    """Draw the cases, and say how the searches went.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: not in a clone, a wrong option, or matplotlib is missing.
    """
    from ucon.core.output import say_written, stdout_to_stderr
    from ucon.evaluation.figures.plotting import require_matplotlib
    from ucon.programs.case_figures import draw_cases
    from ucon.task.own_home.shipped import CASES

    require_matplotlib()
    with stdout_to_stderr():
        drawn = draw_cases((f"agent={args.agent}", f"task={args.task}"), args.figure)
    for path, searches in drawn.items():
        print(f"{path.stem}: a robot that reads the habit {CASES[path.stem].expected}")
        for search in searches:
            record = search.record
            ending = "found" if record.success else f"not found ({record.failure_cause.replace('_', ' ')})"
            length = f"{record.path_length_m:.1f} m (shortest {record.shortest_path_m:.1f})"
            print(f"  {search.level:<10} {ending} after {record.steps} steps, {length}, SPL {record.spl:.2f}")
        say_written(path, "waypoints and maps")
    return 0
