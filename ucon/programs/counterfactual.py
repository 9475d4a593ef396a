"""Plays the episodes of a run again, each time without one sentence, and finds the sentences that were causes.

Each play is an ordinary evaluation with ``env.source.edits``, in its own folder below the output folder. So it can be
interrupted and continued, replayed, watched and reported:

- ``told``: all episodes that have a sentence to try, with all their sentences;
- ``removed-K``: the same, without the sentence of the K-th largest weight;
- ``pairs/told``, ``pairs/removed``, ``pairs/elsewhere``, ``pairs/renamed``: the episodes that have a cause, with their
  strongest cause as it is, taken out, with the thing placed elsewhere, and with its landmark renamed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.core.files import canonical_json, write_atomic
from ucon.core.progress import Progress
from ucon.envs.told.edits import Edit, save_edits
from ucon.evaluation.causes.causes import ABOUT, About, Tried, about, confirmed, counts, strongest, tried
from ucon.evaluation.causes.changes import placed_elsewhere, renamed
from ucon.evaluation.causes.weighing import Weighed, weighed
from ucon.evaluation.kept.record import EpisodeRecord, read_records
from ucon.habits.types import HabitDataset
from ucon.perception.belief.from_habits import ReadHabits
from ucon.programs.evaluating import Evaluation
from ucon.task.episode import Episode
from ucon.task.sets import save_episodes

#: Levels that give habits, in a list that does not change during an episode.
_LEVELS: Final = ("full", "gt", "retrieval")
#: So few episodes are played without workers: starting them would take longer.
_FEW: Final = 12
#: Ways to withhold a sentence besides taking it out: by name, the function that makes the sentence told instead.
_CHANGES: Final[Mapping[str, Callable[[HabitDataset, Episode, int], str | None]]] = {
    "elsewhere": placed_elsewhere,
    "renamed": renamed,
}


@dataclass(frozen=True)
class Found:
    """What playing counterfactuals found."""

    tried: tuple[Tried, ...]
    """All sentences that were taken out, in the order of the episodes."""
    counts: dict[str, dict[str, Any]]
    """Figures of :func:`ucon.evaluation.causes.causes.counts`."""
    episodes: int
    told: int
    """Sentences that the agent is told in all episodes.

    Those that were not tried have no weight or less weight, or are about something else than what was asked for.
    """


class Counterfactuals:
    """Finds the causes of the searches of a run.

    Args:
        config: of the run, resolved and checked.
        out: folder for all plays.
        most: number of sentences that are tried in an episode, those of the largest weight first.
        kinds: what a sentence has to be about to be tried.

    Raises:
        ConfigError: an agent that reads no habits, a level that gives none or a list that changes, a run with edits.
    """

    def __init__(self, config: dict[str, Any], out: Path, most: int, kinds: Collection[About] = ABOUT) -> None:
        self._out, self._most, self._kinds, source = out, most, kinds, config["env"]["source"]
        if source.get("edits") is not None:
            raise ConfigError(
                f"edits={source['edits']}: the habits of this run were edited already; give a run without edits"
            )
        self._config = config | {"pictures": 0}
        whole = Evaluation(self._config, out / "told")
        if not whole.parts.uses_habits or whole.level not in _LEVELS:
            raise ConfigError(
                f"{whole.label} at level {whole.level}: expected an agent that reads habits, at level "
                f"{', '.join(_LEVELS)}"
            )
        self._level, self._source = whole.level, whole.source
        self._episodes = {episode.id: episode for episode in whole.episodes}

    def play(self) -> Found:
        """Play what is missing, and write ``cases.jsonl`` (all sentences tried) and ``cases.json`` (figures)."""
        found: list[Tried] = []
        given, by_episode = self._weighed()
        some = [name for name, habits in by_episode.items() if habits]
        told = self._played("told", [], some) if some else {}
        for k in range(self._most):
            nth = {name: habits[k] for name, habits in by_episode.items() if len(habits) > k}
            if not nth:
                break
            edits = [Edit(name, habit.habit, None) for name, habit in nth.items()]
            without = self._played(f"removed-{k + 1}", edits)
            found += [
                tried(self._episodes[name], self._source.dataset, habit, told[name], without[name])
                for name, habit in nth.items()
            ]
        number = {name: k for k, name in enumerate(self._episodes)}
        found.sort(key=lambda one: number[one.episode])
        figures = counts(found, list(self._episodes), self._confirmed(strongest(found)))
        self._keep(found, {"episodes": len(self._episodes), "told": given, "counts": figures})
        return Found(tuple(found), figures, len(self._episodes), given)

    def _weighed(self) -> tuple[int, dict[str, list[Weighed]]]:
        """Number of sentences told in all, and the sentences of each episode to be tried, by descending weight."""
        locate = getattr(Factory(self._config["agent"])(), "locate", None) or ReadHabits()
        self._source.prepare(level=self._level)
        dataset, given, out = self._source.dataset, 0, {}
        with Progress("weighing habits", len(self._episodes), unit="episodes") as progress:
            for number, (name, episode) in enumerate(self._episodes.items(), 1):
                knowledge = self._source.knowledge(episode, self._level)
                rows, texts = knowledge.rows.tolist(), knowledge.texts
                habits = weighed(episode.target_category, self._level, rows, texts, locate)
                out[name] = [habit for habit in habits if about(episode, dataset, habit.row) in self._kinds]
                given += len(texts)
                progress.update(number)
        return given, out

    def _confirmed(self, causes: Mapping[str, Tried]) -> dict[str, bool]:
        """Play the pairs of the causes; by episode, whether the other ways to withhold its sentence agree."""
        if not causes:
            return {}
        names = [name for name in self._episodes if name in causes]
        self._played("pairs/told", [], names)
        self._played("pairs/removed", [Edit(name, causes[name].habit, None) for name in names])
        others: dict[str, dict[str, EpisodeRecord]] = {}
        for kind, change in _CHANGES.items():
            said = {name: change(self._source.dataset, self._episodes[name], causes[name].row) for name in names}
            edits = [Edit(name, causes[name].habit, text) for name, text in said.items() if text is not None]
            others[kind] = self._played(f"pairs/{kind}", edits) if edits else {}
        in_all = set.intersection(*map(set, others.values()))
        return {
            name: confirmed(causes[name], [records[name] for records in others.values()])
            for name in names
            if name in in_all
        }

    def _played(
        self, name: str, edits: Sequence[Edit], episodes: Sequence[str] | None = None
    ) -> dict[str, EpisodeRecord]:
        """Records of an evaluation with edits, by episode; it is played unless that was done before.

        Args:
            name: of its folder.
            edits: one per episode.
            episodes: ids of the episodes; None: those of the edits.
        """
        path = self._out / f"{name}.episodes.jsonl.xz"
        chosen = set(episodes if episodes is not None else (edit.episode for edit in edits))
        save_episodes([episode for key, episode in self._episodes.items() if key in chosen], path)
        env, file = self._config["env"], None
        if edits:
            file = self._out / f"{name}.edits.jsonl"
            save_edits(edits, file)
        source = env["source"] | {"edits": None if file is None else str(file)}
        config = self._config | {"episodes": str(path), "limit": None, "every": 1}
        if len(chosen) <= _FEW:
            config["workers"] = 0
        return self._records(Evaluation(config | {"env": env | {"source": source}}, self._out / name))

    @staticmethod
    def _records(run: Evaluation) -> dict[str, EpisodeRecord]:
        print(f"{run.out}: {len(run.episodes)} episodes", file=sys.stderr, flush=True)
        run.play()
        return {record.episode: record for record in read_records(run.out)}

    def _keep(self, found: Sequence[Tried], figures: Mapping[str, Any]) -> None:
        lines = "".join(f"{canonical_json(one.to_json())}\n" for one in found)
        write_atomic(self._out / "cases.jsonl", lines)
        write_atomic(self._out / "cases.json", f"{canonical_json(figures)}\n")
