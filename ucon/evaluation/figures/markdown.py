"""The tables of a results page in Markdown: runs, paired differences, and both by home size and by split."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import chain, pairwise
from math import isnan
from pathlib import Path
from typing import Any, Final, get_args

from ucon.core.errors import ConfigError
from ucon.evaluation.figures.bias_table import HEAD, bias_rows
from ucon.evaluation.figures.gap_closed import CELLS, DISTANCES, carried_over, distance_closed
from ucon.evaluation.figures.intervals import Interval, mean_interval, rate_interval
from ucon.evaluation.figures.paired import Comparison
from ucon.evaluation.figures.subsets import is_against_common_sense
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.finished import FinishedRun, figures_only
from ucon.evaluation.kept.naming import agent_label, level
from ucon.evaluation.kept.record import EpisodeRecord, read_records
from ucon.evaluation.kept.seal import has_summary
from ucon.scenes.own import is_own
from ucon.task.outcome import FailureCause

#: Limits of the classes of home sizes in square metres, around the sizes of the calibration study.
SIZE_LIMITS_M2 = (0, 40, 70, 115, 170, 250, 600)
#: Step limits for which success is reported.
BUDGETS: Final = (75, 150, 300)
#: Subsets of episodes for which results are reported, by name.
NAMED: Final[Mapping[str, Callable[[EpisodeRecord], bool]]] = {
    "contained targets": lambda r: r.contained,
    "targets against common sense": is_against_common_sense,
}
#: Names of generated homes begin with this word and a colon.
GENERATED: Final = "procedural"


@dataclass(frozen=True)
class Run:
    """Records of one run with its label in tables."""

    label: str
    records: tuple[EpisodeRecord, ...]
    figures: Mapping[str, Any] = field(default_factory=dict)
    """Content of its ``summary.json``; empty without one."""


def read_run(path: Path) -> Run:
    """Read a run folder of ``eval.py``, or its records alone; or several runs of one agent, joined by ``+``.

    With a summary the label also names the language model and the detector.

    Args:
        path: folder, or ``episodes.jsonl``; ``A+B`` for the episodes of both.

    Raises:
        ConfigError: runs of different agents or levels are joined.
        DataError: no records there, or a damaged file.
    """
    if not path.exists() and "+" in str(path):
        parts = [read_run(Path(part)) for part in str(path).split("+")]
        if len(labels := dict.fromkeys(part.label for part in parts)) > 1:
            raise ConfigError(f"{path}: joins runs of {' and '.join(labels)}; join those of one agent and level")
        return Run(parts[0].label, tuple(record for part in parts for record in part.records))
    if has_summary(path):
        run = FinishedRun.read(path)
        if run.records is None:
            raise figures_only([path])
        return Run(run.label, run.records, run.summary)
    records = tuple(read_records(path))
    said = {"agent": records[0].agent, "habit_level": records[0].habit_level}
    return Run(f"{agent_label(said)}, {level(said)}", records)


def read_runs(folders: Sequence[Path]) -> dict[Path, Run]:
    """Read run folders; runs with the same label get the name of their folder added.

    Args:
        folders: of the runs.

    Raises:
        DataError: no records in one of them.
    """
    if bare := [folder for folder in folders if has_summary(folder) and FinishedRun.read(folder).records is None]:
        raise figures_only(bare)
    runs = {folder: read_run(folder) for folder in folders}
    labels = [run.label for run in runs.values()]
    return {
        folder: replace(run, label=f"{run.label}: {folder.name}") if labels.count(run.label) > 1 else run
        for folder, run in runs.items()
    }


def named_apart(runs: Sequence[Run]) -> None:
    """Raise :class:`ConfigError` where two runs have the same label."""
    labels = [run.label for run in runs]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise ConfigError(f"two runs of '{twice[0]}'; give their folders different names")


def kind_of_home(scene: str) -> str:
    """``generated flats``, ``generated houses``, ...; ``own homes``; ``scenes``, which are copied from BEHAVIOR."""
    if is_own(scene):
        return "own homes"
    generated, _, kind = scene.partition(":")
    return f"generated {kind.partition(':')[0]}s" if generated == GENERATED else "scenes"


def markdown_page(
    runs: Sequence[Run],
    comparisons: Sequence[Comparison],
    way: tuple[Run, Run] | None = None,
    kinds: Mapping[str, Sequence[Comparison]] | None = None,
    groups: Mapping[str, Sequence[Comparison]] | None = None,
) -> str:
    """All tables of some runs, separated by empty lines.

    Args:
        runs: the runs that are shown.
        comparisons: paired differences.
        way: start and goal for distance closed; None: no such column.
        kinds: the same comparisons within each kind of home; None: no such table.
        groups: the same comparisons within groups by what may make habits pay off; None: no such table.

    Raises:
        ConfigError: two runs have the same label.
    """
    named_apart(runs)
    tables = [_runs(runs, way), _differences(comparisons)]
    if kinds is not None:
        tables.append(_within("SPL by kind of home", kinds))
    if groups is not None:
        tables.append(_within("SPL within", groups))
    tables += [_budgets(runs), *_named(runs), _causes(runs)]
    if bias := [row for run in runs for row in bias_rows(run.label, run.figures)]:
        tables.append(_table(HEAD, bias))
    if way is not None and (carried := _carried(runs, way[1])):
        tables.append(carried)
    sizes = _sizes(runs)
    if len(sizes) > 1:
        tables.append(_groups(runs, sizes, lambda r: size_class(area_m2(r.scene))))
    splits = sorted({r.split for run in runs for r in run.records})
    if len(splits) > 1:
        tables.append(_groups(runs, splits, lambda r: r.split))
    return "\n\n".join(tables)


def _runs(runs: Sequence[Run], way: tuple[Run, Run] | None) -> str:
    head = ["agent, habits", "n", "SR % [95 %]", "SPL [95 %]", "SR 75", "SR 150", "steps", "SR contained"]
    rows = [_run_row(run.label, run.records) for run in runs]
    if way is not None:
        head += [f"% closed: {name}" for name in DISTANCES]
        rows = [row + _closed(run, *way) for row, run in zip(rows, runs, strict=True)]
    return _table(head, rows)


def _closed(run: Run, start: Run, goal: Run) -> tuple[str, ...]:
    """Distance closed by one run, in percent."""
    if run is start or run is goal:
        return (f"{100 * (run is goal)}",) * len(DISTANCES)
    found = distance_closed(run.records, start.records, goal.records).values()
    return tuple(_percent(share) for share in found)


def _carried(runs: Sequence[Run], goal: Run) -> str:
    """Table of SR over the goal's SR in seen and unseen cells; "" where no run has such cells."""
    kinds = [name for name, _, _ in CELLS]
    head = [f"% of the SR of {goal.label}"]
    head += [f"{part} {kind}" for kind in kinds for part in ("seen", "unseen", "lost:")]
    rows = []
    for run in runs:
        found = carried_over(run.records, goal.records)
        cells = [(one.seen, one.unseen, one.lost) for one in map(found.get, kinds) if one is not None]
        if run is not goal and len(cells) == len(kinds):
            rows.append((run.label, *(_percent(share) for cell in cells for share in cell)))
    return _table(head, rows) if rows else ""


def _percent(share: Interval) -> str:
    return "-" if isnan(share.mean) else f"{100 * share.mean:.0f} [{100 * share.low:.0f}, {100 * share.high:.0f}]"


def _run_row(label: str, records: Sequence[EpisodeRecord]) -> tuple[str, ...]:
    lives = lives_of(records)
    success = rate_interval([r.success for r in records], clusters=lives)
    spl = mean_interval([r.spl for r in records], clusters=lives)
    hidden = [r for r in records if r.contained]
    return (
        label,
        str(len(records)),
        f"{100 * success.mean:.1f} [{100 * success.low:.1f}, {100 * success.high:.1f}]",
        f"{spl.mean:.3f} [{spl.low:.3f}, {spl.high:.3f}]",
        f"{100 * _mean(records, lambda r: r.success_75):.1f}",
        f"{100 * _mean(records, lambda r: r.success_150):.1f}",
        f"{_mean(records, lambda r: r.steps):.0f}",
        f"{100 * _mean(hidden, lambda r: r.success):.1f}" if hidden else "-",
    )


def _differences(comparisons: Sequence[Comparison]) -> str:
    rows = [
        (
            f"({c.first}) - ({c.second})",
            str(c.n),
            _signed(c.differences["spl"], 3),
            _signed(c.differences["success_rate"], 3),
            _signed(c.differences["steps"], 1),
        )
        for c in comparisons
    ]
    return _table(("paired difference", "n", "SPL", "SR", "steps"), rows)


def _within(title: str, groups: Mapping[str, Sequence[Comparison]]) -> str:
    """Table of the differences in SPL within groups of episodes, by their names."""
    rows = [
        (name, str(pairs[0].n), *(_signed(pair.differences["spl"], 3) for pair in pairs))
        for name, pairs in groups.items()
    ]
    some = next(iter(groups.values()))
    return _table((title, "n", *(f"({c.first}) - ({c.second})" for c in some)), rows)


def _budgets(runs: Sequence[Run]) -> str:
    """Table of SR / SPL of every run where a success counts only within each of the step limits."""
    rows = [(run.label, *(_within_steps(run.records, most) for most in BUDGETS)) for run in runs]
    return _table(("SR / SPL within", *(f"{most} steps" for most in BUDGETS)), rows)


def _within_steps(records: Sequence[EpisodeRecord], most: int) -> str:
    found = [float(r.success and r.steps <= most) for r in records]
    spl = [r.spl * one for r, one in zip(records, found, strict=True)]
    return f"{sum(found) / len(records):.3f} / {sum(spl) / len(records):.3f}"


def _named(runs: Sequence[Run]) -> list[str]:
    """Table of SR and SPL with intervals on the named subsets that have episodes in every run; [] if there are none."""
    names = [name for name, has in NAMED.items() if all(any(map(has, run.records)) for run in runs)]
    if not names:
        return []
    head = ["subset", *(f"{name}: {what}" for name in names for what in ("n", "SR % [95 %]", "SPL [95 %]"))]
    rows = []
    for run in runs:
        parts = [[r for r in run.records if NAMED[name](r)] for name in names]
        rows.append((run.label, *chain(*(_run_row("", part)[1:4] for part in parts))))
    return [_table(head, rows)]


def _causes(runs: Sequence[Run]) -> str:
    """Table of failure causes, in percent of all episodes of each run."""
    there = {r.failure_cause for run in runs for r in run.records if not r.success}
    causes = [cause for cause in get_args(FailureCause) if cause in there]
    rows = []
    for run in runs:
        counts = Counter(r.failure_cause for r in run.records)
        rows.append((run.label, *(f"{100 * counts[cause] / len(run.records):.1f}" for cause in causes)))
    return _table(("% failed by cause", *(cause.replace("_", " ") for cause in causes)), rows)


def _groups(runs: Sequence[Run], names: Sequence[str], group: Callable[[EpisodeRecord], str]) -> str:
    """Table of SR / SPL of every run in every group, with the number of episodes per group."""
    rows = []
    for run in runs:
        parts = [[r for r in run.records if group(r) == name] for name in names]
        rows.append((run.label, *(_rates(part) for part in parts)))
    rows.append(("n", *(str(sum(group(r) == name for r in runs[0].records)) for name in names)))
    return _table(("SR / SPL", *names), rows)


def _rates(records: Sequence[EpisodeRecord]) -> str:
    if not records:
        return "-"
    return f"{_mean(records, lambda r: r.success):.2f} / {_mean(records, lambda r: r.spl):.2f}"


def _sizes(runs: Sequence[Run]) -> list[str]:
    """Size classes that occur, from small to large."""
    areas = {area_m2(scene) for scene in {r.scene for run in runs for r in run.records}}
    return list(dict.fromkeys(size_class(area) for area in sorted(areas)))


def size_class(floor_m2: float) -> str:
    """Class of homes by floor area, in words: ``40-70 m2``."""
    for low, high in pairwise(SIZE_LIMITS_M2):
        if floor_m2 < high:
            return f"{low}-{high} m2"
    return f"from {SIZE_LIMITS_M2[-1]} m2"


@lru_cache(maxsize=4096)
def area_m2(scene: str) -> float:
    """Floor area of a home, square metres."""
    from ucon.scenes import home_spec  # compiled kernels, which most tables do not need

    return home_spec(scene).area_m2


def _mean(records: Sequence[EpisodeRecord], measure: Callable[[EpisodeRecord], float]) -> float:
    return sum(map(measure, records)) / len(records)


def _signed(interval: Interval, digits: int) -> str:
    return f"{interval.mean:+.{digits}f} [{interval.low:+.{digits}f}, {interval.high:+.{digits}f}]"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
