"""One person's run: an evaluation in a thread, whose agent asks the page for every action."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError, UconError
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.playing.human import HumanAgent
from ucon.evaluation.playing.play import PlayedEpisode
from ucon.pages.serve.play.endings import ended
from ucon.pages.serve.play.journal import Journal
from ucon.pages.serve.play.sights import Sights
from ucon.programs.evaluating import Evaluation
from ucon.task.agent import Info, Observation
from ucon.task.rules import task_rules

#: Longest wait in seconds for the next view; this includes building a home.
_PATIENCE_S: Final = 120.0


class _Stopped(Exception):  # noqa: N818 (no error: the person or the server leaves)
    """The game is left; the actions so far are in the journal."""


class Game:
    """A run of :class:`ucon.programs.evaluating.Evaluation` that a person plays.

    The thread of the run waits in :meth:`choose`; requests of the page read :meth:`state` and call :meth:`act`. The run
    itself, its records and its files are like those of any agent.
    """

    def __init__(self, evaluation: Evaluation, journal: Journal) -> None:
        """Prepare a game; :meth:`start` begins it.

        Args:
            evaluation: evaluation of agent ``human`` that has not begun.
            journal: of its actions.
        """
        self.evaluation, self._journal = evaluation, journal
        self._index = {episode.id: number for number, episode in enumerate(evaluation.episodes)}
        self._rules = task_rules(str(evaluation.config["task"]["name"]))
        self._changed = threading.Condition()
        self._sights: Sights | None = None
        self._recorded: Iterator[int] = iter(())
        self._view: dict[str, Any] | None = None
        self._step = 0
        self._given: int | None = None
        self._records: dict[str, EpisodeRecord] = {}
        self._last: EpisodeRecord | None = None
        self._problem, self._over, self._stopping = "", False, False
        agent = HumanAgent(str(evaluation.config["agent"]["player"]))
        agent.hand = self
        evaluation.spec = replace(evaluation.spec, agent=lambda: agent)
        self._thread = threading.Thread(target=self._run, name=f"play {evaluation.out}", daemon=True)

    def start(self) -> None:
        """Begin, or continue where an earlier server stopped."""
        self._thread.start()

    def stop(self, patience_s: float = _PATIENCE_S) -> None:
        """Leave the game; it can be continued later.

        Args:
            patience_s: longest time to wait until its thread has ended.
        """
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(patience_s)

    @property
    def alive(self) -> bool:
        """Whether the run is still being played."""
        return self._thread.is_alive()

    def _run(self) -> None:
        try:
            self.evaluation.play(self._played)
        except _Stopped:
            pass
        except UconError as error:
            self._problem = str(error)
        except Exception as error:  # a bug: shown on the page, with its traceback in the server's terminal
            traceback.print_exc(file=sys.stderr)
            self._problem = f"{type(error).__name__}: {error}"
        with self._changed:
            self._over, self._view = True, None
            self._changed.notify_all()

    def _played(self, played: PlayedEpisode) -> None:
        with self._changed:
            self._last = self._records[played.record.episode] = played.record

    def begin(self, info: Info) -> None:
        """An episode begins; see :class:`ucon.evaluation.playing.human.Hand`."""
        with self._changed:
            self._sights = Sights(info)
            self._recorded = iter(self._journal.of(self._sights.episode))
            self._step = 0

    def choose(self, observation: Observation, info: Info) -> int:
        """The next action: from the journal, then from the person."""
        sights = self._sights
        assert sights is not None
        effect = sights.see(observation, info)
        with self._changed:
            recorded = next(self._recorded, None)
            if recorded is None:
                self._view = sights.shown(observation) | {"effect": effect}
                self._changed.notify_all()
                while self._given is None and not self._stopping:
                    self._changed.wait()
                if self._given is None:
                    raise _Stopped
                recorded, self._given, self._view = self._given, None, None
            self._step += 1
            return recorded

    def act(self, episode: str, step: int, action: int) -> dict[str, Any]:
        """Carry out an action of the person.

        An action that arrives twice, or from a page that shows an earlier state, does nothing.

        Args:
            episode: id of the episode that the page shows.
            step: number of steps that the page shows.
            action: 0 to 6.

        Returns:
            The state after it; ``dropped``: whether the action did nothing.

        Raises:
            DataError: it could not be stored, so it was not carried out.
        """
        with self._changed:
            self._wait()
            sights = self._sights
            shown = self._view is not None and sights is not None and (sights.episode, self._step) == (episode, step)
            if shown:
                self._journal.add(episode, action)
                self._given, self._view = action, None
                self._changed.notify_all()
        return self.state() | {"dropped": not shown}

    def state(self) -> dict[str, Any]:
        """What the page shows now.

        Returns:
            ``over``; ``done`` and ``n`` episodes and the figures so far; ``view`` of the current episode, None after
            the last; ``last``, the id of the last finished episode; ``ended``, all finished episodes once ``over``.

        Raises:
            ConfigError: the run cannot continue; says why.
        """
        with self._changed:
            self._wait()
            found: dict[str, Any] = {
                "over": self._over,
                "done": len(self._records),
                "n": len(self.evaluation.episodes),
                "level": self.evaluation.level,
                "run": str(self.evaluation.out),
                "last": self._last and self._last.episode,
                "view": None,
            }
            if self._view is not None and self._sights is not None:
                found["view"] = {
                    **self._view,
                    "episode": self._sights.episode,
                    "number": self._index[self._sights.episode] + 1,
                    "target": self._sights.target,
                    "context": self._sights.context,
                    "n_habits": len(self._sights.habits),
                    "step": self._step,
                    "max_steps": self._rules.max_steps,
                }
            records = list(self._records.values())
        found["figures"] = _figures(records)
        found["ended"] = [_told(record) for record in records] if found["over"] else []
        return found

    def habits(self) -> list[str]:
        """Sentences that are given in the current episode."""
        with self._changed:
            self._wait()
            return list(self._sights.habits) if self._sights is not None else []

    def result(self, episode: str) -> dict[str, Any]:
        """What is shown of an episode that is over.

        Args:
            episode: its id.

        Raises:
            ConfigError: it is not over, or not of this run.
        """
        with self._changed:
            record = self._records.get(episode)
        if record is None or episode not in self._index:
            raise ConfigError("this episode is not over yet; its result is shown when it is")
        rig = self.evaluation.config["env"].get("rig")
        return ended(
            self.evaluation.episodes[self._index[episode]],
            record,
            self.evaluation.source,
            None if rig is None else Factory(rig)(),
        )

    def rules(self) -> list[dict[str, str]]:
        """Names and effects of the seven actions."""
        return self._rules.actions()

    def know(self, records: list[EpisodeRecord]) -> None:
        """Take note of what was played before this server began.

        Args:
            records: of the run.
        """
        with self._changed:
            self._records |= {record.episode: record for record in records}

    def _wait(self) -> None:
        """Wait until the person can act, or the game is over or left; the lock is held.

        Raises:
            ConfigError: the run failed, was left, or takes too long.
        """
        if not self._changed.wait_for(lambda: self._view is not None or self._over or self._stopping, _PATIENCE_S):
            raise ConfigError("the home is still loading; try again in a moment")
        if self._problem:
            raise ConfigError(self._problem)
        if self._stopping:
            raise ConfigError("you have left this search; continue it on the page Play")


def _told(record: EpisodeRecord) -> dict[str, Any]:
    """A line about an episode that is over."""
    why = record.failure_cause.replace("_", " ")
    target = record.target.replace("_", " ")
    found = {"episode": record.episode, "target": target, "success": record.success, "why": why}
    return found | {"steps": record.steps, "spl": record.spl}


def _figures(records: list[EpisodeRecord]) -> dict[str, Any] | None:
    """Success rate and SPL so far; None before the first episode is over."""
    if not records:
        return None
    found = summarise(records)
    return {name: found[name] for name in ("n", "success_rate", "success_rate_ci95", "spl", "spl_ci95", "steps")}
