"""Bootstrap intervals. They are seeded, so the same records always give the same table.

Episodes of one home are not independent. With ``clusters`` (for example the scene of each episode) whole homes are
resampled, which widens the interval to what another sample of homes would give.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ucon.core.errors import ConfigError
from ucon.core.rng import stream

RESAMPLES = 10_000
#: Resampled values in memory at once; limits one call to about 32 MB.
_BLOCK = 2_000_000
#: 97.5 % point of the normal distribution, for Wilson's interval.
_Z95 = 1.959963984540054


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % interval over ``n`` values."""

    mean: float
    low: float
    high: float
    n: int

    @property
    def ci95(self) -> tuple[float, float]:
        """Lower and upper limit."""
        return self.low, self.high

    @property
    def excludes_zero(self) -> bool:
        """Whether both limits are on one side of zero; never for a single value, which says nothing about others."""
        return self.n > 1 and (self.low > 0 or self.high < 0)


def mean_interval(
    values: ArrayLike, *, clusters: Sequence[str] | None = None, seed: int = 0, resamples: int = RESAMPLES
) -> Interval:
    """Mean with its percentile bootstrap interval.

    Args:
        values: (n,) finite numbers.
        clusters: (n,) names of units that are resampled as a whole; None: each value by itself.
        seed: of the samples.
        resamples: number of samples.

    Raises:
        ConfigError: no values, or some that are not finite.
    """
    data = _checked(values)
    sums, counts = _groups(data, clusters)
    means = _bootstrap_means(sums, counts, seed, resamples)
    low, high = np.quantile(means, (0.025, 0.975))
    return Interval(float(data.mean()), float(low), float(high), len(data))


def rate_interval(
    successes: ArrayLike, *, clusters: Sequence[str] | None = None, seed: int = 0, resamples: int = RESAMPLES
) -> Interval:
    """Share of successes with its bootstrap interval.

    If all values are equal, the bootstrap would give an interval of width 0; Wilson's interval is used instead.

    Args:
        successes: (n,) bool.
        clusters: (n,) names of units that are resampled as a whole; None: each value by itself.
        seed: of the samples.
        resamples: number of samples.

    Raises:
        ConfigError: no values.
    """
    data = _checked(successes)
    if 0.0 < data.mean() < 1.0:
        return mean_interval(data, clusters=clusters, seed=seed, resamples=resamples)
    return wilson_interval(float(data.mean()), len(data))


def wilson_interval(rate: float, n: int) -> Interval:
    """Wilson's 95 % interval of a share; needs no resampling.

    Args:
        rate: the share, 0 to 1.
        n: number of values, at least 1.
    """
    centre = (rate + _Z95**2 / (2 * n)) / (1 + _Z95**2 / n)
    half = _Z95 / (1 + _Z95**2 / n) * np.sqrt(rate * (1 - rate) / n + _Z95**2 / (4 * n * n))
    return Interval(rate, float(max(0.0, centre - half)), float(min(1.0, centre + half)), n)


def paired_difference(
    first: ArrayLike,
    second: ArrayLike,
    *,
    clusters: Sequence[str] | None = None,
    seed: int = 0,
    resamples: int = RESAMPLES,
) -> Interval:
    """Mean of ``first - second`` over the same episodes in the same order, with its bootstrap interval.

    Args:
        first: (n,) values.
        second: (n,) values.
        clusters: (n,) names of units that are resampled as a whole; None: each pair by itself.
        seed: of the samples.
        resamples: number of samples.

    Raises:
        ConfigError: different lengths, no values, or some that are not finite.
    """
    a, b = _checked(first), _checked(second)
    if len(a) != len(b):
        raise ConfigError(f"paired difference of {len(a)} and {len(b)} values; expected the same episodes in both")
    return mean_interval(a - b, clusters=clusters, seed=seed, resamples=resamples)


def _checked(values: ArrayLike) -> NDArray[np.float64]:
    data = np.asarray(values, np.float64)
    if data.ndim != 1 or not len(data):
        raise ConfigError(f"an interval of values of shape {data.shape}; expected at least one value, evaluate more")
    if not np.isfinite(data).all():
        raise ConfigError(f"{int((~np.isfinite(data)).sum())} of {len(data)} values are not finite")
    return data


def _groups(
    data: NDArray[np.float64], clusters: Sequence[str] | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sum and size of every unit that is resampled as a whole."""
    if clusters is None:
        return data, np.ones_like(data)
    if len(clusters) != len(data):
        raise ConfigError(f"{len(clusters)} cluster names for {len(data)} values; expected one each")
    _, index = np.unique(np.asarray(clusters, str), return_inverse=True)
    sums: NDArray[np.float64] = np.bincount(index, weights=data).astype(np.float64)
    return sums, np.bincount(index).astype(np.float64)


def _bootstrap_means(
    sums: NDArray[np.float64], counts: NDArray[np.float64], seed: int, resamples: int
) -> NDArray[np.float64]:
    units = len(sums)
    rng = stream(seed, "bootstrap", units, resamples)
    block = max(1, _BLOCK // units)
    means = [np.empty(0)]
    for start in range(0, resamples, block):
        drawn = rng.integers(units, size=(min(block, resamples - start), units))
        means.append(sums[drawn].sum(1) / counts[drawn].sum(1))
    return np.concatenate(means)
