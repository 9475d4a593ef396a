"""Hydra callback for sweeps (``eval.py -m``)."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig


class CompareAtEnd(Callback):
    """Prints a table of all runs and their paired differences after a sweep."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        """Print the tables of the sweep's folder. Called by Hydra.

        Args:
            config: of the sweep.
            kwargs: unused.
        """
        print_sweep(Path(config.hydra.sweep.dir))


def print_sweep(folder: Path) -> None:
    """Print the tables of all finished runs of a sweep: results, and the paired differences worth comparing.

    Args:
        folder: of the sweep; its subfolders are runs.
    """
    from ucon.core.output import wide_console
    from ucon.evaluation.figures.paired import compare_records, comparison_table
    from ucon.evaluation.figures.report import results_table
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.evaluation.kept.naming import agent_label, is_worth_comparing, level
    from ucon.evaluation.kept.seal import SUMMARY

    paths = sorted(p.parent for p in folder.glob(f"*/{SUMMARY}"))
    if len(paths) < 2:
        return
    runs = [(run.summary, run.records or ()) for run in map(FinishedRun.read, paths)]
    runs.sort(key=lambda run: (agent_label(run[0]), _LEVEL_ORDER.get(level(run[0]), 9)))
    console = wide_console()
    console.print(results_table([summary for summary, _ in runs], title=str(folder)))
    pairs = [
        compare_records(records_a, records_b, (f"{agent_label(a)} {level(a)}", f"{agent_label(b)} {level(b)}"))
        for (a, records_a), (b, records_b) in permutations(runs, 2)
        if is_worth_comparing(a, b) and {r.episode for r in records_a} & {r.episode for r in records_b}
    ]
    if pairs:
        console.print(comparison_table(pairs, ("success_rate", "spl")))
    print(f"see all of them, episode by episode: python -m ucon report {folder}")


_LEVEL_ORDER = {"none": 0, "full": 1, "gt": 2, "retrieval": 3, "context": 4}
