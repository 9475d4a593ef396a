"""How far a run gets from a baseline run towards an upper bound, and how well it generalises to unseen things.

Plain exploration does well in homes, so SR alone says little. *Distance closed* is (run - start) / (goal - start) over
the same episodes; with ``frontier`` as start and ``oracle_locations`` as goal it is 0 for reading nothing and 1 for
perfect reading. *Generalisation* is SR divided by the goal's SR in the same cell of episodes, which are equally hard.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.evaluation.figures.intervals import RESAMPLES, Interval
from ucon.evaluation.kept.record import EpisodeRecord

Records = Sequence[EpisodeRecord]
#: Measures of distance: SPL, SR within 150 steps, and SR on targets behind closed doors.
DISTANCES: Final[Mapping[str, Callable[[EpisodeRecord], float]]] = {
    "SPL": lambda r: r.spl,
    "SR 150": lambda r: float(r.success_150),
    "SR contained": lambda r: float(r.success) if r.contained else np.nan,
}
#: Parts of an episode's ``split`` that are compared: (name, seen, unseen).
CELLS: Final = (("category", "seen_category", "unseen_category"), ("scene", "seen_scene", "unseen_scene"))


@dataclass(frozen=True)
class Shares:
    """SR over the goal's SR in seen and in unseen episodes, and the difference."""

    seen: Interval
    unseen: Interval
    lost: Interval


def distance_closed(run: Records, start: Records, goal: Records) -> dict[str, Interval]:
    """Share of the way from ``start`` to ``goal`` by each of :data:`DISTANCES`; the bootstrap draws episodes jointly.

    Where the goal is no better than the start, or no episode counts, the share is NaN.

    Args:
        run: records of the run.
        start: records of the baseline.
        goal: records of the upper bound.

    Raises:
        ConfigError: no episode that all three have played.
    """
    ours, first, last = _common(run, start, goal)
    out = {}
    for name, measure in DISTANCES.items():
        values = np.array([[measure(r) for r in records] for records in (ours, first, last)])
        values = values[:, ~np.isnan(values).any(0)]
        come, whole = values[0] - values[1], values[2] - values[1]
        out[name] = _ratio(come, whole, "closed", name)
    return out


def carried_over(run: Records, goal: Records) -> dict[str, Shares]:
    """SR over the goal's SR in seen and unseen episodes, by category and by scene.

    Only for runs whose splits name seen and unseen cells; empty otherwise.

    Args:
        run: records of the run.
        goal: records of the upper bound.

    Raises:
        ConfigError: no episode that both have played.
    """
    ours, last = _common(run, goal)
    pairs = [(r.split, float(r.success), float(g.success)) for r, g in zip(ours, last, strict=True)]
    out = {}
    for name, seen, unseen in CELLS:
        parts = [[(a, b) for split, a, b in pairs if cell in split.split("/")] for cell in (seen, unseen)]
        if not all(parts):
            continue
        above, below = zip(*(np.array(part).T for part in parts), strict=True)
        found = [_ratio(a, b, "carried", cell) for a, b, cell in zip(above, below, (seen, unseen), strict=True)]
        draws = [_draws(a, b, "carried", cell) for a, b, cell in zip(above, below, (seen, unseen), strict=True)]
        lost = _interval(found[0].mean - found[1].mean, draws[0] - draws[1], len(pairs))
        out[name] = Shares(found[0], found[1], lost)
    return out


def _common(*runs: Records) -> list[list[EpisodeRecord]]:
    """Records of every run for the episodes that all have played, in one order."""
    by_episode = [{r.episode: r for r in records} for records in runs]
    episodes = sorted(set.intersection(*(set(found) for found in by_episode)))
    if not episodes:
        raise ConfigError("the runs have no episode in common; compare runs on the same episodes")
    return [[found[episode] for episode in episodes] for found in by_episode]


def _ratio(above: NDArray[np.float64], below: NDArray[np.float64], *what: str) -> Interval:
    """Sum over sum with a bootstrap interval over episodes."""
    if below.sum() <= 0:
        return Interval(np.nan, np.nan, np.nan, len(above))
    return _interval(float(above.sum() / below.sum()), _draws(above, below, *what), len(above))


def _draws(above: NDArray[np.float64], below: NDArray[np.float64], *what: str) -> NDArray[np.float64]:
    n = len(above)
    counts = stream(0, "ratio", *what, n).multinomial(n, np.full(n, 1 / n), RESAMPLES).astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        drawn: NDArray[np.float64] = (counts @ above) / (counts @ below)
    return drawn


def _interval(share: float, draws: NDArray[np.float64], n: int) -> Interval:
    draws = draws[np.isfinite(draws)]
    if not len(draws):
        return Interval(np.nan, np.nan, np.nan, n)
    low, high = np.quantile(draws, (0.025, 0.975))
    return Interval(share, float(low), float(high), n)
