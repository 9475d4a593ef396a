"""Recomputes the figures of a finished run from its records; adds checksums where an older version wrote none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ucon.core.files import write_atomic
from ucon.evaluation.figures.metrics import same_figures, summarise
from ucon.evaluation.figures.report import seconds_of
from ucon.evaluation.kept.decisions import language_figures
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.seal import (
    DECISIONS,
    SEALED,
    SECONDS,
    SUMMARY,
    TIMING,
    is_sealed,
    read_files,
    read_unsealed,
    sealed,
)


@dataclass(frozen=True)
class Verification:
    """Result of recomputing a run."""

    label: str
    n: int
    sealed: bool
    """Whether there are checksums (a wrong one raises an error)."""
    recomputed: tuple[str, ...]
    """Names of the figures that were recomputed."""
    differing: tuple[str, ...]
    """Names of those that came out different."""
    taken: tuple[str, ...]
    """Names of entries that cannot be recomputed, since they depend on configuration, machine and clock."""

    @property
    def good(self) -> bool:
        """Whether all recomputed figures agree and there are checksums."""
        return self.sealed and not self.differing


def verify(folder: Path, *, seal: bool = False) -> Verification:
    """Recompute a run's figures from its records and compare them with its summary.

    Args:
        folder: of a finished run.
        seal: if all agree, write the recomputed figures with checksums of the files that are there.

    Raises:
        DataError: no finished run, or a damaged one.
    """
    has_seal = is_sealed(folder)
    run = FinishedRun.of(read_files(folder, whole=not seal) if has_seal else read_unsealed(folder))
    now, kept = _recomputed(run), run.summary | run.seconds
    differing = tuple(name for name in now if not same_figures(now[name], kept.get(name)))
    if seal and not differing:
        _write(run, now)
        has_seal = True
    taken = tuple(name for name in kept if name not in now)
    return Verification(run.label, run.summary["n"], has_seal, tuple(now), differing, taken)


def _recomputed(run: FinishedRun) -> dict[str, Any]:
    """All figures that follow from the stored records, decisions and timing."""
    if run.records is None:
        return {}
    agents, levels = {r.agent for r in run.records}, {r.habit_level for r in run.records}
    now = {"agent": ", ".join(sorted(agents)), "habit_level": ", ".join(sorted(levels))} | summarise(run.records)
    made = run.decisions()
    if DECISIONS in run.content:
        now["language"] = language_figures([d for r in run.records for d in made.get(r.episode, ())], len(run.records))
    if TIMING in run.content and (DECISIONS in run.content or run.summary.get("language") is None):
        seconds = seconds_of(list(run.played().values()), 0.0)
        now |= {name: value for name, value in seconds.items() if name != "seconds"}
    return now


def _write(run: FinishedRun, now: Mapping[str, Any]) -> None:
    """Write seconds and summary; the summary last, since it marks the run as complete."""
    for name, said in ((SECONDS, run.seconds), (SUMMARY, run.summary)):
        files = {part: run.content[part] for part in SEALED[name] if part in run.content}
        write_atomic(run.folder / name, sealed({key: now.get(key, value) for key, value in said.items()}, files))
