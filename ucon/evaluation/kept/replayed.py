"""A kept run and the same run played again: whether its numbers come out, episode by episode.

Folders of ``results/`` keep a run's configuration and ``summary.json``, many also the record of every episode. Records
are compared as they are written, byte by byte; without them the figures of the summary are.
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
class Kept:
    """What a folder keeps of a run."""

    label: str
    figures: dict[str, Any]
    records: list[EpisodeRecord] | None
    """None where the folder holds figures alone."""

    def check(self, episodes: Sequence[str], every: int = 1) -> None:
        """Refuse to play ``episodes``, named by their ids, where they are not every ``every``-th of what is kept.

        Raises:
            DataError: other episodes are kept, or figures of all alone and a part is to be played.
        """
        if self.records is None:
            if every != 1:
                raise DataError(f"{self.label}: no episodes are kept, only figures of all of them; play all (every 1)")
            same = self.figures.get("n", len(episodes)) == len(episodes)
        else:
            same = [record.episode for record in self.records[::every]] == list(episodes)
        if not same:
            raise DataError(f"{self.label}: other episodes are kept than its configuration names now")

    @classmethod
    def read(cls, folder: Path) -> Kept:
        """Read it.

        Raises:
            DataError: no summary of a run there, or damaged records.
        """
        run = FinishedRun.read(folder)
        return cls(run.label, run.summary, None if run.records is None else list(run.records))


@dataclass(frozen=True)
class Replayed:
    """What came out."""

    label: str
    n: int
    by: str
    """What was compared: ``episodes``, or ``figures`` where none were kept."""
    differing: tuple[str, ...]
    """Names of the episodes or figures that came out otherwise."""
    kept: dict[str, float]
    now: dict[str, float]
    """SR and SPL, as kept and as played now."""

    @property
    def same(self) -> bool:
        """Whether all came out as it is kept."""
        return not self.differing


def replayed(kept: Kept, now: Sequence[EpisodeRecord], every: int = 1) -> Replayed:
    """Compare what was kept with what was played now: every ``every``-th episode of it, see :meth:`Kept.check`."""
    new = summarise(now)
    if kept.records is None:
        names = [name for name in new if name in kept.figures and not same_figures(new[name], kept.figures[name])]
        return Replayed(kept.label, len(now), "figures", tuple(names), _main(kept.figures), _main(new))
    chosen = kept.records[::every]
    differing = [b.episode for a, b in zip(chosen, now, strict=True) if a.to_line() != b.to_line()]
    return Replayed(kept.label, len(now), "episodes", tuple(differing), _main(summarise(chosen)), _main(new))


def _main(figures: dict[str, Any]) -> dict[str, float]:
    return {name: round(float(figures[name]), 6) for name in ("success_rate", "spl")}
