"""Evaluate an agent on stored episodes.

    python eval.py agent=belief habit_level=retrieval episodes=mini
    python eval.py -m agent=frontier,belief habit_level=none,full,gt,retrieval

Writes episodes.jsonl, summary.json, timing.jsonl, seconds.json, config.yaml, and maps and videos of some episodes to
``out=``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ucon.programs.ready  # noqa: F401 (says what to do without the environment)

# isort: split
import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from rich.console import Console

from ucon.core.output import is_wide, wide_console
from ucon.evaluation.figures.bias_table import bias_line
from ucon.evaluation.figures.report import failure_line, precision_line, results_table
from ucon.programs.errors import one_line_errors, run_entry
from ucon.programs.evaluating import Evaluation
from ucon.programs.sweep import folder_of


@hydra.main(version_base="1.3", config_path="configs", config_name="eval")
def main(cfg: DictConfig) -> None:
    """Evaluate one run; Hydra calls this once for each combination of a sweep."""
    hydra_config = HydraConfig.get()
    swept = folder_of(hydra_config, str(cfg.episodes)) if hydra_config.mode == RunMode.MULTIRUN else None
    with one_line_errors("eval", swept):
        evaluate_and_report(cfg, swept or Path(str(cfg.out)).absolute(), sweep=swept is not None)


def evaluate_and_report(cfg: DictConfig, out: Path, *, sweep: bool) -> None:
    """Play the episodes that are missing in the output folder, then write and print the results.

    In a sweep, an agent that reads no habits is played at its first habit level only.

    Args:
        cfg: configuration.
        out: output folder.
        sweep: whether this run is part of a sweep.

    Raises:
        UconError: an error that the user can fix.
    """
    config: dict[str, Any] = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)  # type: ignore[assignment]
    run = Evaluation(config, out)
    if sweep and (twin := run.twin()) is not None:
        print(f"{run.label} reads no habits: its results are those in {twin}")
        return
    figures = run.play()
    wide = is_wide()
    (wide_console() if wide else Console()).print(results_table([figures], wide=wide))
    print(*filter(None, [failure_line(figures), precision_line(figures), bias_line(figures)]), sep="\n")
    print(f"{run.seconds:.1f} s for {run.n_new} episode{'s' * (run.n_new != 1)}; results in {out}")
    if not sweep:
        print(f"see every episode: python -m ucon report {out}")


if __name__ == "__main__":
    run_entry(main, "eval")
