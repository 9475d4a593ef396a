"""Tables of runs of lives: by day, by last sighting of the thing, and by what habits say. Intervals resample lives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from rich.table import Table

from ucon.evaluation.figures.intervals import Interval, mean_interval, rate_interval
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.lives.request_record import LifeFacts

#: Last days (counted from 1) of the groups of days.
_DAYS: Final = (3, 7, 14, 30)

Group = Callable[[LifeFacts], str]


def by_day(facts: LifeFacts) -> str:
    """Days 1-3, 4-7, 8-14, ... of the life, counted from 1."""
    first = 1
    for last in _DAYS:
        if facts.day < last:
            return f"days {first}-{last}"
        first = last + 1
    return f"days {first} on"


def by_sight(facts: LifeFacts) -> str:
    """Whether the robot had seen the thing before, and whether it was moved since then."""
    if facts.seen_days_ago is None:
        return "never seen before"
    return "moved since last seen" if facts.moved else "where it was last seen"


def by_word(facts: LifeFacts) -> str:
    """Whether the thing is at a place that a told sentence's entry names."""
    return "where a told sentence says" if facts.obeys else "where none says"


def by_change(facts: LifeFacts) -> str:
    """Whether the habits about the thing have changed."""
    return "habits changed" if facts.changed else "habits as at first"


GROUPS: Final[Mapping[str, Group]] = {"day": by_day, "sight": by_sight, "word": by_word, "change": by_change}


def grouped(records: Sequence[EpisodeRecord]) -> list[tuple[str, list[EpisodeRecord]]]:
    """All records, and those of each group, in the order of :data:`GROUPS`.

    Args:
        records: of a run of lives.
    """
    found: list[tuple[str, list[EpisodeRecord]]] = [("all", list(records))]
    for group in GROUPS.values():
        parts: dict[str, list[EpisodeRecord]] = {}
        for record in sorted(records, key=_day):
            assert record.life is not None
            parts.setdefault(group(record.life), []).append(record)
        found += parts.items() if group is by_day else sorted(parts.items())
    return found


def figures_of(records: Sequence[EpisodeRecord]) -> dict[str, Any]:
    """Number of requests, SR and SPL with their intervals, and steps.

    Args:
        records: at least one.
    """
    success, spl = intervals_of(records)
    steps = sum(record.steps for record in records) / len(records)
    return {
        "n": len(records),
        "success_rate": success.mean,
        "success_rate_ci95": list(success.ci95),
        "spl": spl.mean,
        "spl_ci95": list(spl.ci95),
        "steps": steps,
    }


def intervals_of(records: Sequence[EpisodeRecord]) -> tuple[Interval, Interval]:
    """SR and SPL of some records."""
    lives = lives_of(records)
    return (
        rate_interval([record.success for record in records], clusters=lives),
        mean_interval([record.spl for record in records], clusters=lives),
    )


def lives_table(label: str, records: Sequence[EpisodeRecord]) -> Table:
    """A table with one row per group.

    Args:
        label: of the run.
        records: of a run of lives.
    """
    table = Table(title=label, title_justify="left")
    table.add_column("requests", no_wrap=True)
    for name in ("n", "SR % [95 %]", "SPL [95 %]", "steps"):
        table.add_column(name, justify="right", no_wrap=True)
    for name, part in grouped(records):
        table.add_row(name, *_cells(part))
    return table


def lives_markdown(runs: Sequence[tuple[str, Sequence[EpisodeRecord]]]) -> str:
    """SPL of several runs as Markdown: one row per group, one column per run.

    Args:
        runs: label and records of each.
    """
    rows: dict[str, list[str]] = {}
    for column, (_, records) in enumerate(runs):
        for name, part in grouped(records):
            spl = intervals_of(part)[1]
            rows.setdefault(name, [""] * len(runs))[column] = f"{spl.mean:.3f} [{spl.low:.3f}, {spl.high:.3f}]"
    labels = [label for label, _ in runs]
    lines = ["| SPL | " + " | ".join(labels) + " |", "| --- |" + " --- |" * len(labels)]
    lines += [f"| {name} | " + " | ".join(cells) + " |" for name, cells in rows.items()]
    return "\n".join(lines)


def _cells(part: Sequence[EpisodeRecord]) -> tuple[str, ...]:
    success, spl = intervals_of(part)
    return (
        str(len(part)),
        f"{100 * success.mean:.1f} [{100 * success.low:.1f}, {100 * success.high:.1f}]",
        f"{spl.mean:.3f} [{spl.low:.3f}, {spl.high:.3f}]",
        f"{sum(record.steps for record in part) / len(part):.0f}",
    )


def _day(record: EpisodeRecord) -> int:
    return -1 if record.life is None else record.life.day
