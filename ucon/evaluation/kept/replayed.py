"""Compares a stored run with the same run played again, episode by episode.

Folders of ``results/`` store a run's configuration and ``summary.json``, many also the record of every episode. Records
are compared byte by byte; where there are none, the figures of the summary are compared instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ucon.core.errors import DataError
from ucon.evaluation.figures.metrics import same_figures, summarise
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.record import EpisodeRecord


@dataclass(frozen=True)
class StoredRun:
    """Stored figures and records of a run."""

    label: str
    figures: dict[str, Any]
    records: list[EpisodeRecord] | None
    """None where only figures are stored."""

    def check(self, episodes: Sequence[str], every: int = 1) -> None:
        """Refuse to play episodes that are not every ``every``-th of the stored ones.

        Args:
            episodes: ids of what is to be played.
            every: 1 for all.

        Raises:
            DataError: other episodes are stored; or only figures of the whole run are stored and ``every`` is not 1.
        """
        if self.records is None:
            if every != 1:
                raise DataError(f"{self.label}: no episodes are kept, only their overall figures; play all (every 1)")
            same = self.figures.get("n", len(episodes)) == len(episodes)
        else:
            same = [record.episode for record in sampled(self.records, every)] == list(episodes)
        if not same:
            raise DataError(f"{self.label}: its configuration now names other episodes than those kept")

    @classmethod
    def read(cls, folder: Path) -> StoredRun:
        """Read a folder of a finished run.

        Raises:
            DataError: no summary of a run there, or damaged records.
        """
        run = FinishedRun.read(folder)
        return cls(run.label, run.summary, None if run.records is None else list(run.records))


@dataclass(frozen=True)
class ReplayResult:
    """Result of the comparison."""

    label: str
    n: int
    by: str
    """What was compared: ``episodes``, or ``figures`` where no records are stored."""
    differing: tuple[str, ...]
    """Names of the episodes or figures that came out different."""
    kept: dict[str, float]
    now: dict[str, float]
    """SR and SPL as played now; ``kept`` has the stored ones."""

    @property
    def same(self) -> bool:
        """Whether everything came out as stored."""
        return not self.differing


def replayed(kept: StoredRun, now: Sequence[EpisodeRecord], every: int = 1) -> ReplayResult:
    """Compare stored records or figures with episodes played now.

    Args:
        kept: the stored run.
        now: records of every ``every``-th episode, see :meth:`StoredRun.check`.
        every: 1 for all.
    """
    new = summarise(now)
    if kept.records is None:
        names = [name for name in new if name in kept.figures and not same_figures(new[name], kept.figures[name])]
        return ReplayResult(kept.label, len(now), "figures", tuple(names), _main(kept.figures), _main(new))
    chosen = sampled(kept.records, every)
    differing = [b.episode for a, b in zip(chosen, now, strict=True) if a.to_line() != b.to_line()]
    return ReplayResult(kept.label, len(now), "episodes", tuple(differing), _main(summarise(chosen)), _main(new))


def sampled(records: Sequence[EpisodeRecord], every: int) -> list[EpisodeRecord]:
    """Records of every ``every``-th episode, or of all requests of every ``every``-th life."""
    lives = list(dict.fromkeys(record.life.life for record in records if record.life is not None))
    if not lives:
        return list(records[::every])
    chosen = set(lives[::every])
    return [record for record in records if record.life is not None and record.life.life in chosen]


def _main(figures: dict[str, Any]) -> dict[str, float]:
    return {name: round(float(figures[name]), 6) for name in ("success_rate", "spl")}
