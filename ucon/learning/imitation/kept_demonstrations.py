"""Demonstrations that were played once: their actions, kept in the user's cache for later runs.

An agent that searches is deterministic, so what it did in an episode at a habit level is what it would do again. A file
has a line for each: episode, habit level, actions. Its name is a hash of all that they depend on.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from ucon.core.files import user_cache
from ucon.learning.imitation.demonstrators import Demonstrator
from ucon.learning.imitation.trajectories import Trajectory
from ucon.learning.policies.playing import Job
from ucon.task.actions import Action

_DIGITS: Final = frozenset(str(int(action)) for action in Action)


class KeptDemonstrations:
    """Actions by episode and habit level; new ones are appended to the file.

    Args:
        demonstrator: whose demonstrations they are.
    """

    def __init__(self, demonstrator: Demonstrator) -> None:
        key = demonstrator.cache_key()
        self._file: Path | None = user_cache() / "demonstrations" / f"{key[:32]}.jsonl" if key else None
        self._actions: dict[tuple[str, str], str] = {}
        self._torn = False
        if self._file is not None and self._file.is_file():
            # A line that is incomplete or of another form is ignored: its demonstration is played again.
            text = self._file.read_text("utf-8", errors="replace")
            self._torn = not text.endswith("\n")
            for line in text.splitlines():
                if (row := _row(line)) is not None:
                    self._actions[row[0], row[1]] = row[2]

    def __len__(self) -> int:
        return len(self._actions)

    def get(self, job: Job) -> Trajectory | None:
        """The demonstration of an episode at a level; None where it was not played yet."""
        actions = self._actions.get(_key(job))
        return None if actions is None else Trajectory(job.episode, job.level, actions, actions)

    def keep(self, job: Job, trajectory: Trajectory) -> None:
        """Keep what was played; only in memory if it cannot be written, as on a full disk."""
        if _key(job) in self._actions:
            return
        self._actions[_key(job)] = trajectory.actions
        if self._file is None:
            return
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with self._file.open("a", encoding="utf-8") as out:
                out.write("\n" * self._torn + json.dumps([*_key(job), trajectory.actions]) + "\n")
            self._torn = False
        except OSError:
            self._file = None


def _key(job: Job) -> tuple[str, str]:
    """Episode, with the hash of its home, and level."""
    return f"{job.episode.id} {job.episode.home_hash} {job.episode.seed}", job.level


def _row(line: str) -> tuple[str, str, str] | None:
    """A line's episode, level and actions; None where it is no such line."""
    try:
        row: Any = json.loads(line)
    except ValueError:
        return None
    if not (isinstance(row, list) and len(row) == 3 and all(isinstance(text, str) for text in row)):
        return None
    return (row[0], row[1], row[2]) if row[2] and _DIGITS.issuperset(row[2]) else None
