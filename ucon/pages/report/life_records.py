"""What can be shown of lives from their records: every request as a cell of a calendar, and figures by day.

Only the records are needed, so a run can be shown while it is played.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ucon.evaluation.figures.intervals import mean_interval
from ucon.evaluation.kept.record import EpisodeRecord


def rows_by_life(records: Sequence[EpisodeRecord]) -> dict[str, list[dict[str, Any]]]:
    """The requests of each life, in order.

    Args:
        records: of lives; others are left out.

    Returns:
        By id of the life, one row per request, see :func:`row_of`.
    """
    found: dict[str, list[EpisodeRecord]] = {}
    for record in records:
        if record.life is not None:
            found.setdefault(record.life.life, []).append(record)
    return {life: [row_of(record) for record in sorted(some, key=_number)] for life, some in found.items()}


def row_of(record: EpisodeRecord) -> dict[str, Any]:
    """What a calendar shows of a request.

    Args:
        record: of a life.
    """
    assert record.life is not None
    facts = record.life
    return {
        "request": facts.request,
        "day": facts.day,
        "slot": facts.slot,
        "target": record.target,
        "found": record.success,
        "spl": round(record.spl, 3),
        "steps": record.steps,
        "cause": record.failure_cause,
        "seen": facts.seen_days_ago,
        "moved": facts.moved,
        "changed": facts.changed,
    }


def curves_of(records: Sequence[EpisodeRecord]) -> dict[str, list[list[float | None]]]:
    """SR and SPL by day of the life, averaged over lives.

    Args:
        records: of lives.

    Returns:
        ``sr`` and ``spl``: for each day (from 1), the mean and its 95 % interval over lives, which is None, None where
        a single life has that day.
    """
    return {
        "sr": _curve(records, lambda record: float(record.success)),
        "spl": _curve(records, lambda record: record.spl),
    }


def _curve(records: Sequence[EpisodeRecord], of: Callable[[EpisodeRecord], float]) -> list[list[float | None]]:
    days: dict[int, dict[str, list[float]]] = {}
    for record in records:
        if record.life is not None:
            days.setdefault(record.life.day, {}).setdefault(record.life.life, []).append(of(record))
    return [[day + 1, *_over_lives([sum(some) / len(some) for some in days[day].values()])] for day in sorted(days)]


def _over_lives(means: Sequence[float]) -> list[float | None]:
    """Mean of some lives' means, lower and upper limit."""
    if len(means) == 1:
        return [round(means[0], 4), None, None]
    interval = mean_interval(means)
    return [round(value, 4) for value in (interval.mean, interval.low, interval.high)]


def _number(record: EpisodeRecord) -> int:
    return -1 if record.life is None else record.life.request
