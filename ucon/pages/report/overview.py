"""The figures of a report: every run with its intervals, paired differences, and both within groups of episodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from ucon.evaluation.figures.groups import GROUPS
from ucon.evaluation.figures.intervals import Interval, mean_interval, rate_interval
from ucon.evaluation.figures.markdown import Run
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.record import EpisodeRecord

#: Resamples of the intervals within groups, of which there are hundreds.
_RESAMPLES: Final = 2_000


def figures_of(records: Sequence[EpisodeRecord], resamples: int = 10_000) -> dict[str, Any]:
    """SR and SPL with their 95 % intervals, and the other figures that tables show.

    Args:
        records: at least one.
        resamples: of the bootstrap.
    """
    n, lives = len(records), lives_of(records)
    return {
        "n": n,
        "sr": _interval(rate_interval([r.success for r in records], clusters=lives, resamples=resamples)),
        "spl": _interval(mean_interval([r.spl for r in records], clusters=lives, resamples=resamples)),
        "steps": round(sum(r.steps for r in records) / n, 1),
        "seen": round(sum(r.first_seen_step >= 0 for r in records) / n, 4),
    }


def groups_of(runs: Sequence[Run]) -> dict[str, list[dict[str, Any]]]:
    """Figures within groups of episodes.

    Args:
        runs: of the report.

    Returns:
        By title of :data:`ucon.evaluation.figures.groups.GROUPS`, the groups from the largest to the smallest:
        ``name``, and ``runs``, the figures of each run, None where it has no such episode. Titles with one group are
        left out.
    """
    found = {}
    for title, of in GROUPS.items():
        parts: dict[str, list[list[EpisodeRecord]]] = {}
        for number, run in enumerate(runs):
            for record in run.records:
                parts.setdefault(of(record), [[] for _ in runs])[number].append(record)
        if len(parts) > 1:
            ordered = sorted(parts.items(), key=lambda part: (-sum(map(len, part[1])), part[0]))
            found[title] = [
                {"name": name, "runs": [figures_of(some, _RESAMPLES) if some else None for some in by_run]}
                for name, by_run in ordered
            ]
    return found


def differences_of(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Paired differences of every two runs that share episodes, the later minus the earlier one.

    Args:
        runs: of the report.
    """
    found = []
    for b, second in enumerate(runs):
        for a, first in enumerate(runs[:b]):
            if not {r.episode for r in first.records} & {r.episode for r in second.records}:
                continue
            pair = compare_records(second.records, first.records, (second.label, first.label))
            found.append(
                {"first": b, "second": a, "n": pair.n}
                | {
                    short: _interval(pair.differences[name])
                    for short, name in (("sr", "success_rate"), ("spl", "spl"), ("steps", "steps"))
                }
            )
    return found


def _interval(interval: Interval) -> list[float]:
    """Mean, lower and upper limit."""
    return [round(v, 4) for v in (interval.mean, interval.low, interval.high)]
