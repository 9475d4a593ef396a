"""One run of ``eval.py``: from its configuration to a folder with results; ``python -m ucon replay`` plays by it."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from omegaconf import OmegaConf

from ucon.configuration.arguments import check_arguments
from ucon.configuration.known_options import EVALUATION, check_options
from ucon.configuration.wiring import Factory
from ucon.core.sole_writer import sole_writer
from ucon.evaluation.figures.report import run_hashes, summary, versions
from ucon.evaluation.kept.folder import RunFolder, free_folder
from ucon.evaluation.kept.naming import parts_of
from ucon.evaluation.kept.seal import has_summary
from ucon.evaluation.kept.twins import twin_of
from ucon.evaluation.playing.needed_weights import check_weights, fingerprints
from ucon.evaluation.playing.pictures import worth_filming
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.evaluation.playing.progress_bar import EvaluationProgress, embedding_progress
from ucon.evaluation.playing.runner import evaluate
from ucon.retrieval.levels import check_level
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


class Evaluation:
    """A run whose parts are made and checked, to be played into the folder ``out``.

    Args:
        config: resolved, as ``configs/eval.yaml`` has it.
        out: an earlier, equal run in it goes on; a finished one is read.
        anew: play it whatever lies there, in ``out`` or, where that holds another run or a finished one, beside it.
    """

    def __init__(self, config: dict[str, Any], out: Path, *, anew: bool = False) -> None:
        check_options(config, EVALUATION)
        check_arguments(config["env"])  # which is built last, by whoever plays
        task = config["task"]
        self.level = str(config["habit_level"]["name"])
        check_level(self.level)
        self.episodes = chosen_episodes(
            config["episodes"], config["limit"], task["name"], context=task["context"], every=config["every"]
        )
        warn_of_other_rules(self.episodes, task["name"])
        agent, detector = Factory(config["agent"])(), Factory(config["env"]["detector"])()
        self.parts, self.source = parts_of(agent, detector), Factory(config["env"]["source"])()
        if anew or not has_summary(out):  # a finished run is only read again
            check_weights(agent, detector)
        # What ranks habits counts only where they are read: whoever reads none has one run for all levels.
        of_habits = self.source.weights(self.level if self.parts.uses_habits else "none")
        of_parts = fingerprints(agent, detector)
        self.hashes = run_hashes(config, self.episodes, None if of_parts is None else (*of_habits, *of_parts))
        self.out = free_folder(out, self.hashes, versions()) if anew else out
        self.config = config | {"out": str(self.out)} if anew else config
        self.spec = RunSpec(
            agent=Factory(config["agent"]),
            env=Factory(config["env"], {"episodes": self.episodes[:1]}),
            habit_level=self.level,
            seed=config["seed"],
            batch=config["batch"],
        )
        self.n_new, self.seconds = 0, 0.0
        """Episodes that :meth:`play` played, and how long that took."""

    def twin(self) -> Path | None:
        """A finished run beside this one with the same results: of an agent that reads no habits, at another level."""
        return None if self.parts.uses_habits else twin_of(self.out, self.config, self.hashes)

    def play(self) -> dict[str, Any]:
        """Play what is missing in the folder and finish it; the content of its ``summary.json``.

        Of a finished run nothing is played and nothing is written.

        Raises:
            ConfigError: the folder belongs to another run, is written by another command, or cannot be written.
            DataError: what it holds is damaged.
        """
        with contextlib.nullcontext() if has_summary(self.out) else sole_writer(self.out):
            return self._play()

    def _play(self) -> dict[str, Any]:
        folder = RunFolder(self.out, self.hashes, versions())
        done = folder.open([episode.id for episode in self.episodes])
        if folder.summary is not None:
            return folder.summary
        if folder.damaged:
            print(
                f"warning: {self.out}: {folder.damaged} damaged lines of what an interrupted run left; "
                "their episodes are played again",
                file=sys.stderr,
            )
        started = time.perf_counter()
        played = sorted([*done.values(), *self._missing(folder, done)], key=lambda p: p.index)
        self.n_new, self.seconds = len(played) - len(done), time.perf_counter() - started
        figures = summary(played, folder.hashes, self.parts)
        folder.finish(played, figures, OmegaConf.to_yaml(OmegaConf.create(self.config)))
        self._film(played)
        return figures

    def _film(self, played: Sequence[PlayedEpisode]) -> None:
        """Play some episodes again for the camera: which ones are worth it is known at the end only."""
        records = {p.index: p.record for p in played}
        chosen = worth_filming([record.success for record in records.values()], self.config["pictures"])
        if not chosen:
            return
        with EvaluationProgress("films", len(chosen), visible=self.config["progress"]) as progress:

            def on_played(again: PlayedEpisode) -> None:
                progress.add(again)
                if again.record != records[again.index]:
                    print(f"warning: {again.record.episode} came out otherwise on its film", file=sys.stderr)

            evaluate(
                replace(self.spec, films=self.out / "pictures"),
                self.episodes,
                workers=0,  # so few are filmed here before others would have started
                skip=[index for index in records if index not in chosen],
                on_played=on_played,
            )

    def _missing(self, folder: RunFolder, done: dict[int, PlayedEpisode]) -> list[PlayedEpisode]:
        """The episodes that no earlier run has played."""
        config = self.config
        with embedding_progress(visible=config["progress"]) as on_text:
            self.source.prepare(on_text, self.level)
        label = f"{config['agent']['_target_'].rsplit('.', 1)[-1]} {self.level}"
        with EvaluationProgress(label, len(self.episodes), visible=config["progress"], done=done.values()) as progress:

            def on_played(played: PlayedEpisode) -> None:
                folder.add(played)
                progress.add(played)

            return evaluate(
                self.spec,
                self.episodes,
                workers=config["workers"],
                skip=list(done),
                on_played=on_played,
                worker_timeout_s=config["worker_timeout_s"],
            )


def chosen_episodes(name: str, limit: int | None, task: str, *, context: bool, every: int = 1) -> tuple[Episode, ...]:
    """Every ``every``-th episode of a set, the first ``limit`` of these.

    Of the set made under the rules ``task``, stating their context or not.
    """
    check_part(limit, every)
    return load_episodes(name, task, context=context)[::every][:limit]


def check_part(limit: Any, every: Any) -> None:
    """Raises :class:`ConfigError` where no part of a set is chosen so."""
    check_options({"limit": limit, "every": every}, EVALUATION)


def warn_of_other_rules(episodes: tuple[Episode, ...], task: str) -> None:
    """A file by path is played as it is; its shortest paths hold under the rules by which they were found."""
    others = sorted({episode.task for episode in episodes} - {task})
    if others:
        print(
            f"warning: episodes made under task={','.join(others)}, played under task={task}: some may have no "
            "solution, and SPL is measured against the other rules' shortest paths",
            file=sys.stderr,
        )
