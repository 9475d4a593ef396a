"""Train the learned parts of agents: search policies, the habit retriever, the belief head.

    python train.py agent=habit_policy
    python train.py learner=retriever
    python train.py learner=belief
    python train.py agent=vtn learner=imitation
    python train.py agent=vtn learner=dagger
    python train.py learner=retriever habits=official habits.path=FILE
    python train.py resume=runs/train/RUN
    python train.py resume=runs/train/RUN training.steps=400
    python train.py learner=retriever learner.initial=runs/train/RUN

Writes config.yaml, metrics.jsonl, learning_curve.png (where matplotlib is installed), checkpoints/, model/,
MODEL_CARD.md, summary.json and seconds.json to ``out=``.
Ctrl-C and SIGTERM save and end. ``resume=`` continues a run and writes the same bytes as an uninterrupted run would;
with more ``training.steps`` it continues beyond the planned end. ``learner.initial=`` starts a new run from the weights
of another.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import ucon.programs.ready  # noqa: F401 (says what to do without the environment)

# isort: split
import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from ucon.configuration.early_checks import check_early
from ucon.configuration.wiring import Factory
from ucon.core.memory import keep_freed_memory
from ucon.core.pool import pools_from
from ucon.core.sole_writer import sole_writer
from ucon.evaluation.playing.runner import Runner
from ucon.learning.run.learning_curve import learning_curve
from ucon.learning.run.protocol import Learner
from ucon.learning.run.run_plan import Plan
from ucon.learning.run.run_progress import check_wandb, tensorboard_log, training_progress, wandb_log
from ucon.learning.run.stopping import end_at_once
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.training_run import Interrupted, OnFigures, TrainingRun
from ucon.programs.errors import one_line_errors, run_entry
from ucon.programs.training import ChosenRun, chosen_run, learner_name, run_identity, use_threads, write_extension


@hydra.main(version_base="1.3", config_path="configs", config_name="train")
def main(cfg: DictConfig) -> None:
    """Train one run; Hydra calls this once for each combination of a sweep."""
    hydra_config = HydraConfig.get()
    swept = Path(hydra_config.runtime.output_dir) if hydra_config.mode == RunMode.MULTIRUN else None
    with one_line_errors("train", swept):
        train_and_report(cfg, list(hydra_config.overrides.task), swept)


def train_and_report(cfg: DictConfig, overrides: list[str], swept: Path | None = None) -> None:
    """Train to the end, or continue the run that ``resume`` names, and print the best validation figures.

    Args:
        cfg: configuration.
        overrides: options given on the command line.
        swept: folder of this run in a sweep; None: ``out`` of the configuration.

    Raises:
        UconError: an error that the user can fix.
    """
    chosen = chosen_run(cfg, overrides, swept)
    config: dict[str, Any] = chosen.config
    plan = Plan.of(config["training"])  # check first: building the learner takes seconds, and so does importing torch
    check_early(config["learner"])
    use_threads(config["threads"])
    keep_freed_memory()
    check_wandb(config["wandb"])
    runner: Runner = Factory(config["runner"])()
    learner = Factory(config["learner"])()
    resolved: Mapping[str, str | int] = getattr(learner, "resolved_options", {})
    if not chosen.checkpoint:
        config["learner"] |= resolved
    try:
        with closing(learner), sole_writer(chosen.folder), pools_from(runner.pool):
            summary, seconds = _trained(chosen, learner, plan, resolved)
    except Interrupted as stop:
        print(_stopped(chosen, stop), file=sys.stderr)
        sys.exit(128 + stop.number)
    figures = "  ".join(f"{name} {value:g}" for name, value in summary["best"].items())
    print(f"best validation: {figures}\n{seconds:.1f} s; model and card in {chosen.folder}")


def _stopped(chosen: ChosenRun, stop: Interrupted) -> str:
    """The line about a run that a signal stopped."""
    then = "; work started after it will be repeated" if stop.abandoned else ""
    return f"stopped after step {stop.step}, saved{then}; continue with resume={chosen.folder}"


def _trained(
    chosen: ChosenRun, learner: Learner, plan: Plan, resolved: Mapping[str, str | int]
) -> tuple[dict[str, Any], float]:
    """Start or resume a run and train to the end.

    Returns:
        Content of ``summary.json``, and seconds taken.
    """
    config = chosen.config
    run = TrainingRun(chosen.folder, learner, plan, run_identity(chosen.stored or config))
    if chosen.checkpoint:
        run.resume(chosen.checkpoint, chosen.steps)
        if run.plan != plan:
            write_extension(chosen.folder, run.plan)
            print(run.extended(), file=sys.stderr)
    else:
        run.start(OmegaConf.to_yaml(OmegaConf.create(config)))
    if resolved:
        print("computing with", ", ".join(f"{name} {value}" for name, value in resolved.items()), file=sys.stderr)
    with (
        wandb_log(config["wandb"], chosen.folder, config) as log,
        tensorboard_log(bool(config["tensorboard"]), chosen.folder) as write,
        learning_curve(chosen.folder) as draw,
        training_progress(
            learner_name(config["learner"]),
            run.plan.length,
            run.step,
            best=run.best.get(SCORE),
            visible=config["progress"],
        ) as show,
    ):
        return run.run(
            _each(show, log, write, draw), lambda stop: end_at_once(_stopped(chosen, stop), 128 + stop.number)
        ), run.seconds


def _each(*sinks: OnFigures) -> OnFigures:
    """One callback that calls all given callbacks."""

    def tell(step: int, figures: Mapping[str, float]) -> None:
        for sink in sinks:
            sink(step, figures)

    return tell


if __name__ == "__main__":
    run_entry(main, "train")
