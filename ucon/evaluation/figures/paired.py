"""Paired differences between two runs on the episodes that both have played."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rich.table import Table

from ucon.core.errors import ConfigError
from ucon.evaluation.figures.intervals import Interval, paired_difference
from ucon.evaluation.figures.metrics import MEASURES
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.record import EpisodeRecord


@dataclass(frozen=True)
class Comparison:
    """``first - second`` for every measure, over the ``n`` common episodes."""

    first: str
    second: str
    n: int
    only_first: int
    only_second: int
    differences: dict[str, Interval]

    def to_json(self) -> dict[str, Any]:
        """Plain values; each difference with its interval."""
        data = asdict(self)
        data["differences"] = {
            name: {"difference": d.mean, "ci95": list(d.ci95), "excludes_zero": d.excludes_zero}
            for name, d in self.differences.items()
        }
        return data


def compare_records(
    first: Sequence[EpisodeRecord],
    second: Sequence[EpisodeRecord],
    names: tuple[str, str] = ("first", "second"),
    *,
    by_scene: bool = False,
) -> Comparison:
    """Compare two runs on the episodes that both have played.

    Args:
        first: records of one run.
        second: records of the other.
        names: their labels.
        by_scene: True: the bootstrap resamples whole homes. For lives it always resamples whole lives.

    Raises:
        ConfigError: no common episode, or an episode twice in one run.
    """
    a, b = _by_episode(first, names[0]), _by_episode(second, names[1])
    common = sorted(a.keys() & b.keys())
    if not common:
        raise ConfigError(f"{names[0]} and {names[1]} have no episode in common; compare runs on the same episodes")
    clusters = [a[i].scene for i in common] if by_scene else lives_of([a[i] for i in common])
    differences = {
        name: paired_difference([measure(a[i]) for i in common], [measure(b[i]) for i in common], clusters=clusters)
        for name, measure in MEASURES.items()
    }
    return Comparison(*names, len(common), len(a) - len(common), len(b) - len(common), differences)


def comparison_table(
    comparisons: Sequence[Comparison], measures: Sequence[str] = tuple(MEASURES), title: str = "paired differences"
) -> Table:
    """Table with one row per comparison and measure; an asterisk marks intervals that exclude zero.

    Args:
        comparisons: the comparisons that are shown.
        measures: names of :data:`MEASURES`.
        title: of the table.
    """
    table = Table(title=f"{title} (*: the interval excludes 0)", title_justify="left")
    table.add_column("first - second")
    table.add_column("measure", no_wrap=True)
    for column in ("n", "difference", "95 % interval", ""):
        table.add_column(column, justify="right", no_wrap=True)
    for comparison in comparisons:
        for i, name in enumerate(measures):
            d = comparison.differences[name]
            table.add_row(
                f"{comparison.first} - {comparison.second}" if i == 0 else "",
                name,
                str(comparison.n) if i == 0 else "",
                f"{d.mean:+.3f}",
                f"[{d.low:+.3f}, {d.high:+.3f}]" if d.n > 1 else "-",
                "*" if d.excludes_zero else "",
            )
    return table


def _by_episode(records: Sequence[EpisodeRecord], name: str) -> dict[str, EpisodeRecord]:
    found = {record.episode: record for record in records}
    if len(found) != len(records):
        raise ConfigError(f"{name}: {len(records) - len(found)} episodes are listed twice; evaluate again")
    return found
