"""From records to figures: the metrics of the benchmark.

SPL of one episode is ``success * l / max(p, l)``, with l the shortest path and p the length of the successful moves,
both in metres. It is computed when the episode ends; here it is checked again and averaged.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from ucon.core.errors import DataError
from ucon.evaluation.figures.intervals import mean_interval, rate_interval
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.record import EpisodeRecord, episode_spl

#: Figures that can be compared between runs: value of one record by name.
MEASURES: dict[str, Callable[[EpisodeRecord], float]] = {
    "success_rate": lambda r: float(r.success),
    "spl": lambda r: r.spl,
    "soft_spl": lambda r: r.soft_spl,
    "success_75": lambda r: float(r.success_75),
    "success_150": lambda r: float(r.success_150),
    "steps": lambda r: float(r.steps),
    "path_length_m": lambda r: r.path_length_m,
}


def summarise(records: Sequence[EpisodeRecord]) -> dict[str, Any]:
    """All deterministic figures of a run, JSON-ready, with the names of ``summary.json``.

    Args:
        records: of the run, at least one.

    Raises:
        DataError: no records, or one whose SPL does not follow from its lengths.
    """
    if not records:
        raise DataError("no records to summarise; evaluate at least one episode")
    for record in records:
        expected = episode_spl(record.success, record.shortest_path_m, record.path_length_m)
        if abs(expected - record.spl) > 1e-5:
            raise DataError(f"episode {record.episode}: SPL {record.spl:.6f}, its own lengths give {expected:.6f}")
    lives = lives_of(records)
    success = rate_interval([r.success for r in records], clusters=lives)
    spl = mean_interval([r.spl for r in records], clusters=lives)
    figures: dict[str, Any] = {
        "n": len(records),
        "success_rate": success.mean,
        "success_rate_ci95": list(success.ci95),
        "spl": spl.mean,
        "spl_ci95": list(spl.ci95),
    }
    for name in ("soft_spl", "success_75", "success_150", "success_300", "steps", "path_length_m", "opens"):
        figures[name] = _mean([float(getattr(r, name)) for r in records])
    figures |= {
        "collisions": _mean([float(r.collisions) for r in records]),
        "first_seen_step": _mean([float(r.first_seen_step) for r in records if r.first_seen_step >= 0]),
        "seen_rate": _mean([float(r.first_seen_step >= 0) for r in records]),
        "n_habits": _mean([float(r.n_habits) for r in records]),
        "language_calls": sum(r.language_calls for r in records),
        "language_tokens": sum(r.language_tokens for r in records),
        "failure_causes": dict(sorted(Counter(r.failure_cause for r in records if not r.success).items())),
        "retrieval": {
            name: _mean([v for r in records if (v := getattr(r, name)) is not None])
            for name in ("recall_10", "recall_20", "mrr")
        },
    }
    return figures


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


def same_figures(a: Any, b: Any, tolerance: float = 1e-6) -> bool:
    """Whether two figures, or containers of figures, are equal within a tolerance.

    Args:
        a: number, string, list or dictionary.
        b: the same.
        tolerance: absolute; figures are stored with six digits.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(same_figures(a[name], b[name], tolerance) for name in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(same_figures(x, y, tolerance) for x, y in zip(a, b, strict=True))
    if isinstance(a, float | int) and isinstance(b, float | int):
        return abs(a - b) <= tolerance
    return bool(a == b)
