"""``python -m ucon report RUN...``: one HTML file with the tables of runs and every episode."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ucon.configuration.kept_config import add_places, places_in

#: Name of the file in a run's folder.
NAME = "report.html"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.description = (
        "Write report.html into a run's folder (eval.py or train.py): tables with intervals, and every episode with "
        "its map, path, pictures, beliefs, habits and decisions. Several runs are compared, episode by episode. For "
        "runs of lives: figures by day, the calendar of each life, and where each thing was. The file needs no network."
    )
    parser.add_argument(
        "runs", nargs="+", metavar="RUN", type=Path, help="run folders of eval.py (or of a sweep), or one of train.py"
    )
    parser.add_argument(
        "--out", type=Path, help="file to write (default: report.html in the run's folder, or runs/report.html)"
    )
    parser.add_argument(
        "--pictures",
        choices=("auto", "none", "key", "all"),
        default="auto",
        help="steps shown with the camera's picture: none, key (decisions, openings), all; auto chooses by the number "
        "of episodes",
    )
    parser.add_argument(
        "--actions", action="store_true", help="show the recorded actions only, without the agents' beliefs (faster)"
    )
    add_places(parser)


def run(args: argparse.Namespace) -> int:
    """Write the report.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: several runs of which one is of train.py or of another kind than others, or a file that cannot be
            written.
        DataError: a run that cannot be read.
    """
    from ucon.configuration.stored import said_in
    from ucon.core.errors import ConfigError
    from ucon.core.files import write_atomic
    from ucon.core.output import stdout_to_stderr
    from ucon.pages.report.build import build_report
    from ucon.pages.report.training import build_training_report, is_training_run

    out = args.out or (args.runs[0] / NAME if len(args.runs) == 1 else Path("runs") / NAME)
    folders = [run for folder in args.runs for run in _runs_in(folder)]
    trained = [folder for folder in folders if is_training_run(folder)]
    if trained and len(folders) > 1:
        raise ConfigError(f"{trained[0]}: a run of train.py, which has a report of its own; give it alone")
    with stdout_to_stderr():
        text = (
            build_training_report(folders[0])
            if trained
            else build_report(folders, args.pictures, places_in(args), said_in(args), actions_only=args.actions)
        )
    try:
        write_atomic(out, text.encode())
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror}); give another file with --out") from None
    sys.stdout.write(f"{out}: {len(text) / 1e6:.1f} MB, open it in a browser\n")
    return 0


def _runs_in(folder: Path) -> list[Path]:
    """The finished runs of a sweep's folder; else the folder itself."""
    from ucon.evaluation.kept.seal import SUMMARY

    if (folder / SUMMARY).is_file():
        return [folder]
    return sorted(path.parent for path in folder.glob(f"*/{SUMMARY}")) or [folder]
