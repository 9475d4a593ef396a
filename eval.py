"""Evaluate an agent on stored episodes.

    python eval.py agent=belief habit_level=retrieval episodes=mini
    python eval.py -m agent=frontier,belief habit_level=none,full,gt,retrieval

Writes episodes.jsonl, timing.jsonl, summary.json, config.yaml and the first episodes' maps and videos to ``out=``.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from ucon.commands.entry import one_line_errors, run_entry
from ucon.commands.output import wide_console
from ucon.commands.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.envs.knowledge import HabitSource
from ucon.evaluation.folder import SUMMARY, RunFolder
from ucon.evaluation.naming import parts_of
from ucon.evaluation.play import Played, RunSpec
from ucon.evaluation.progress import EvaluationProgress, embedding_progress
from ucon.evaluation.report import failure_line, results_table, run_hashes, summary
from ucon.evaluation.runner import evaluate
from ucon.evaluation.twins import twin_of
from ucon.evaluation.weights import check_weights, fingerprints
from ucon.retrieval.levels import check_level
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


@hydra.main(version_base="1.3", config_path="configs", config_name="eval")
def main(cfg: DictConfig) -> None:
    """One run; Hydra calls it once for each combination of a sweep."""
    with one_line_errors("eval"):
        hydra_config = HydraConfig.get()
        evaluate_and_report(cfg, Path(hydra_config.runtime.output_dir), sweep=hydra_config.mode == RunMode.MULTIRUN)


def evaluate_and_report(cfg: DictConfig, out: Path, *, sweep: bool) -> None:
    """Play what is missing in the output folder ``out``, then write and print the results.

    In a sweep, an agent that reads no habits is played at its first habit level alone.
    """
    config: dict[str, Any] = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)  # type: ignore[assignment]
    task = config["task"]
    check_level(config["habit_level"]["name"])
    episodes = chosen_episodes(
        config["episodes"], config["limit"], task["name"], context=task["context"], every=config["every"]
    )
    warn_of_other_rules(episodes, task["name"])
    agent, detector = Factory(config["agent"])(), Factory(config["env"]["detector"])()
    parts, source = parts_of(agent, detector), Factory(config["env"]["source"])()
    if not (out / SUMMARY).is_file():  # a finished run is only printed again
        check_weights(agent, detector)
    # What ranks habits counts only where they are read: whoever reads none has one run for all levels.
    of_habits = source.weights(config["habit_level"]["name"] if parts.uses_habits else "none")
    of_parts = fingerprints(agent, detector)
    hashes = run_hashes(config, episodes, None if of_parts is None else (*of_habits, *of_parts))
    if sweep and not parts.uses_habits and (twin := twin_of(out, config, hashes)) is not None:
        print(f"{config['agent']['_target_'].rsplit('.', 1)[-1]} reads no habits: its results are those in {twin}")
        return
    folder = RunFolder(out, hashes)
    done = folder.open()
    played, seconds = play_missing(config, source, episodes, folder, done, out)
    figures = summary(played, folder.hashes, seconds, parts)
    folder.finish(played, figures, OmegaConf.to_yaml(OmegaConf.create(config)))
    console = wide_console()
    console.print(results_table([figures]))
    console.print(f"{failure_line(figures)}\n{seconds:.1f} s for {len(played) - len(done)} episodes; results in {out}")


def chosen_episodes(name: str, limit: int | None, task: str, *, context: bool, every: int = 1) -> tuple[Episode, ...]:
    """Every ``every``-th episode of a set, the first ``limit`` of these.

    Of the set made under the rules ``task``, stating their context or not.
    """
    if type(every) is not int or every < 1:
        raise ConfigError(f"every={every}: expected a whole number from 1 up; 5 plays every fifth episode")
    if limit is not None and (not isinstance(limit, int) or limit < 1):
        raise ConfigError(f"limit={limit}: expected a number of episodes from 1 up, or null for all")
    return load_episodes(name, task, context=context)[::every][:limit]


def warn_of_other_rules(episodes: tuple[Episode, ...], task: str) -> None:
    """A file by path is played as it is; its shortest paths hold under the rules by which they were found."""
    others = sorted({episode.task for episode in episodes} - {task})
    if others:
        print(
            f"warning: episodes made under task={','.join(others)}, played under task={task}: some may have no "
            "solution, and SPL is measured against the other rules' shortest paths",
            file=sys.stderr,
        )


def play_missing(
    config: dict[str, Any],
    source: HabitSource,
    episodes: tuple[Episode, ...],
    folder: RunFolder,
    done: dict[int, Played],
    out: Path,
) -> tuple[list[Played], float]:
    """All episodes, those of an earlier run taken over, and the seconds that the others took."""
    spec = RunSpec(
        agent=Factory(config["agent"]),
        env=Factory(config["env"], {"episodes": episodes[:1]}),
        habit_level=config["habit_level"]["name"],
        seed=config["seed"],
        batch=config["batch"],
        pictures=out / "pictures",
        n_pictures=config["pictures"],
    )
    started = time.perf_counter()
    with embedding_progress(visible=config["progress"]) as on_text:
        source.prepare(on_text, spec.habit_level)
    label = f"{config['agent']['_target_'].rsplit('.', 1)[-1]} {spec.habit_level}"
    with EvaluationProgress(label, len(episodes), visible=config["progress"], done=done.values()) as progress:

        def on_played(played: Played) -> None:
            folder.add(played)
            progress.add(played)

        new = evaluate(spec, episodes, workers=config["workers"], skip=list(done), on_played=on_played)
    played = sorted([*done.values(), *new], key=lambda p: p.index)
    return played, time.perf_counter() - started


if __name__ == "__main__":
    run_entry(main, "eval")
