"""One run of ``eval.py``, from its configuration to a folder with results; also used by ``python -m ucon replay``."""

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
from ucon.core.errors import ConfigError
from ucon.core.fingerprint import fingerprint_of
from ucon.core.sole_writer import sole_writer
from ucon.envs.own_home import episodes_of, is_home_file, own_set, say_made
from ucon.evaluation.figures.report import run_hashes, summary, versions
from ucon.evaluation.kept.folder import RunFolder, free_folder
from ucon.evaluation.kept.naming import agent_label, parts_of
from ucon.evaluation.kept.seal import has_summary
from ucon.evaluation.kept.twins import twin_of
from ucon.evaluation.playing.needed_weights import check_weights, fingerprints
from ucon.evaluation.playing.pictures import worth_filming
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.evaluation.playing.progress_bar import EvaluationProgress, embedding_progress
from ucon.evaluation.playing.runner import LOCAL, OnPlayed, Runner, evaluate
from ucon.lives.asked import Asked, asked_of, example
from ucon.lives.sets import load_lives
from ucon.retrieval.levels import check_level
from ucon.task.episode import Episode
from ucon.task.rules import PAPER

#: Name of the task of lives.
RESIDENT = "resident"
_BOOK, _FOLDER = "ucon.habits.book", "ucon.configuration.wiring.folder_habits"


class Evaluation:
    """A run whose parts are built and checked, ready to be played into a folder.

    Args:
        config: resolved, with the options of ``configs/eval.yaml``.
        out: output folder; an earlier, equal run in it is continued, a finished one is only read.
        anew: True: play it in any case, in ``out`` or, if that holds another or a finished run, in a new folder next
            to it.

    Raises:
        ConfigError: a wrong option.
        DataError: weights or episodes are missing or damaged.
    """

    def __init__(self, config: dict[str, Any], out: Path, *, anew: bool = False) -> None:
        check_options(config, EVALUATION)
        config = with_own_habits(config)
        check_arguments(config["env"])  # the environment is built last, in the workers
        task = config["task"]
        self.level = str(config["habit_level"]["name"])
        check_level(self.level)
        resident = task["name"] == RESIDENT
        if resident and config["pictures"]:
            raise ConfigError(f"pictures={config['pictures']}: searches of lives are not filmed; give pictures=0")
        chosen = config["episodes"], config["limit"]
        self.episodes: Sequence[Any] = (
            chosen_requests(*chosen, every=config["every"])
            if resident
            else chosen_episodes(*chosen, task["name"], context=task["context"], every=config["every"])
        )
        """Episodes, or the requests of lives."""
        if is_home_file(config["episodes"]):
            say_made(Path(config["episodes"]), own_set(Path(config["episodes"]), task["name"]))
        warn_of_other_rules(self.episodes, config["env"]["task"])
        agent, detector = Factory(config["agent"])(), Factory(config["env"]["detector"])()
        memory = _memory(config.get("memory"), resident=resident)
        remembered = None if memory is None else memory()
        self.parts = parts_of(agent, detector, remembered)
        self.source = Factory(config["env"]["source"])()
        self.label = agent_label({"agent": agent.name, **self.parts.to_json()})
        """Label of the agent, as in tables."""
        self.source.check_edits(self.episodes)
        errors = getattr(detector, "errors", None)
        judge = getattr(agent, "judge", None) if errors is not None else None  # otherwise no judge is asked
        if anew or not has_summary(out):  # a finished run is only read and needs no weights
            check_weights(agent, detector, judge)
        # Weights that rank habits count only for agents that read habits; other agents have one run for all levels.
        of_habits = self.source.weights(self.level if self.parts.uses_habits else "none")
        of_parts = fingerprints(agent, detector, judge)
        self.hashes = run_hashes(config, self.episodes, None if of_parts is None else (*of_habits, *of_parts))
        if errors is not None:
            self.hashes["detector_errors"] = errors.fingerprint()
        if begins_with := fingerprint_of(remembered):
            self.hashes["memory"] = begins_with
        self.out = free_folder(out, self.hashes, versions()) if anew else out
        self.config = config | {"out": str(self.out)} if anew else config
        self.spec = RunSpec(
            agent=Factory(config["agent"]),
            env=Factory(config["env"], _played_by(self.episodes[0])),
            habit_level=self.level,
            seed=config["seed"],
            batch=config["batch"],
            memory=memory,
        )
        self._runner: Runner = Factory(config["runner"])() if "runner" in config else LOCAL
        self.n_new, self.seconds = 0, 0.0
        """Episodes that :meth:`play` played, and how long that took."""

    def given(self, episode: Episode | Asked) -> tuple[str, ...] | None:
        """Habits that the agent is given at an episode's start, in order; None for an agent that reads none."""
        if isinstance(episode, Asked):
            episode = example(episode, self.source.dataset)
        return self.source.knowledge(episode, self.level).texts if self.parts.uses_habits else None

    def twin(self) -> Path | None:
        """A finished run next to this one that has the same results.

        There is one if the agent reads no habits and was played at another habit level.

        Returns:
            Its folder; None where there is none.
        """
        return None if self.parts.uses_habits else twin_of(self.out, self.config, self.hashes)

    def play(self, on_played: OnPlayed | None = None) -> dict[str, Any]:
        """Play the episodes that are missing in the folder, and finish the run. A finished run is only read.

        Args:
            on_played: called with each episode that is played now, after it was written.

        Returns:
            Content of ``summary.json``.

        Raises:
            ConfigError: the folder belongs to another run, is in use by another command, or cannot be written.
            DataError: its content is damaged.
        """
        with contextlib.nullcontext() if has_summary(self.out) else sole_writer(self.out):
            return self._play(on_played)

    def _play(self, on_end: OnPlayed | None) -> dict[str, Any]:
        folder = RunFolder(self.out, self.hashes, versions())
        done = folder.open([episode.id for episode in self.episodes])
        if folder.summary is not None:
            return folder.summary
        if folder.damaged:
            print(
                f"warning: {self.out}: an interrupted run left {folder.damaged} damaged lines; "
                "their episodes are played again",
                file=sys.stderr,
            )
        started = time.perf_counter()
        played = sorted([*done.values(), *self._missing(folder, done, on_end)], key=lambda p: p.index)
        self.n_new, self.seconds = len(played) - len(done), time.perf_counter() - started
        figures = summary(played, folder.hashes, self.parts)
        folder.finish(played, figures, OmegaConf.to_yaml(OmegaConf.create(self.config)))
        self._film(played)
        return figures

    def _film(self, played: Sequence[PlayedEpisode]) -> None:
        """Play some episodes again for films; which ones (successes and failures) is known only at the end."""
        records = {p.index: p.record for p in played}
        chosen = worth_filming([record.success for record in records.values()], self.config["pictures"])
        if not chosen:
            return
        with EvaluationProgress("films", len(chosen), visible=self.config["progress"]) as progress:

            def on_played(again: PlayedEpisode) -> None:
                progress.add(again)
                if again.record != records[again.index]:
                    print(
                        f"warning: {again.record.episode}: the filmed search differs from the recorded one",
                        file=sys.stderr,
                    )

            evaluate(
                replace(self.spec, films=self.out / "pictures"),
                self.episodes,
                workers=0,  # starting workers would take longer than these few episodes
                skip=[index for index in records if index not in chosen],
                on_played=on_played,
            )

    def _missing(
        self, folder: RunFolder, done: dict[int, PlayedEpisode], on_end: OnPlayed | None
    ) -> list[PlayedEpisode]:
        """Play the episodes that no earlier call has played."""
        config = self.config
        with embedding_progress(visible=config["progress"]) as on_text:
            self.source.prepare(on_text, self.level)
        with EvaluationProgress(
            f"{self.label} {self.level}", len(self.episodes), visible=config["progress"], done=done.values()
        ) as progress:

            def on_played(played: PlayedEpisode) -> None:
                folder.add(played)
                progress.add(played)
                if on_end is not None:
                    on_end(played)

            return evaluate(
                self.spec,
                self.episodes,
                workers=config["workers"],
                skip=list(done),
                on_played=on_played,
                worker_timeout_s=config["worker_timeout_s"],
                runner=self._runner,
            )


def chosen_requests(name: str, limit: int | None, every: int = 1) -> tuple[Asked, ...]:
    """All requests of the chosen lives of a set or file: every ``every``-th life, and of these the first ``limit``."""
    check_part(limit, every)
    return asked_of(load_lives(name)[::every][:limit])


def chosen_episodes(name: str, limit: int | None, task: str, *, context: bool, every: int = 1) -> tuple[Episode, ...]:
    """Every ``every``-th episode of a set, and of these the first ``limit``.

    Args:
        name: set, file, or home file.
        limit: number of episodes; None: all.
        task: rules under which the set was made.
        context: whether its episodes state day, season and occasion.
        every: 1 for all.
    """
    check_part(limit, every)
    if task == RESIDENT:
        raise ConfigError(f"{name}: a run of lives (task=resident); see python -m ucon lives table RUN")
    return episodes_of(name, task, context=context)[::every][:limit]


def _played_by(one: Episode | Asked) -> dict[str, Any]:
    """Argument of the environment that plays an episode, or a request's life."""
    return {"lives": [one.life]} if isinstance(one, Asked) else {"episodes": [one]}


def _memory(config: Any, *, resident: bool) -> Factory | None:
    """Factory of the memory of a robot that lives in one home; None if it has no memory.

    Raises:
        ConfigError: a memory for a robot that does not live there.
    """
    if config is None:
        return None
    if not resident:
        raise ConfigError("memory: only a robot that lives in a home has one; add task=resident")
    check_arguments(config)
    return Factory(config)


def with_own_habits(config: dict[str, Any]) -> dict[str, Any]:
    """The configuration with the habits of its home file, where ``episodes`` names one.

    Args:
        config: resolved.

    Raises:
        ConfigError: it names other habits, too.
    """
    if not is_home_file(config["episodes"]):
        return config
    env, task = config["env"], config["task"]["name"]
    source = env["source"]
    own = {"_target_": _FOLDER, "path": config["episodes"]} | ({} if task == PAPER.name else {"task": task})
    if source["dataset"] not in ({"_target_": _BOOK}, own):
        raise ConfigError(f"habits: episodes={config['episodes']} has its own habits; leave out habits=")
    return config | {"habits": own, "env": env | {"source": source | {"dataset": own}}}


def check_part(limit: Any, every: Any) -> None:
    """Raise :class:`ConfigError` where ``limit`` or ``every`` is out of range."""
    check_options({"limit": limit, "every": every}, EVALUATION)


def warn_of_other_rules(episodes: Sequence[Episode | Asked], task: str) -> None:
    """Warn if episodes were made under other rules than they are played under.

    A file given by path is played as it is; its shortest paths hold only under the rules that it was made under.
    """
    others = sorted({episode.task for episode in episodes} - {task})
    if others:
        print(
            f"warning: episodes made under task={','.join(others)}, played under task={task}: some may have no "
            "solution, and SPL is measured against the other rules' shortest paths",
            file=sys.stderr,
        )
