"""Since when a thing has had its current habits: the posterior over the change point in its sightings.

Sightings before a change say nothing about where the thing is put now. Under each hypothesis (no change, a change
between two sightings, or one after the last) the sightings are predicted one after the other, from those since the
change. How well this works, and how probable a change is on each day, give the posterior.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Probability of a place by given habits and common sense, if the thing was not seen there since the change.
SPREAD = 0.1
#: Least probability of a sighting, since two in one slot may contradict each other.
_LEAST = 1e-3

Array = NDArray[np.float64]


def change_posterior(
    places: NDArray[np.int64], stays: Array, counts: Array, changes: Array, doubt: float, mistakes: float
) -> Array:
    """Probability (n + 1,), for c = 0 .. n, that the current habits are those of the sightings from number c on.

    Args:
        places: (n,) place of every sighting, in order.
        stays: (n,) probability that nobody used the thing since the sighting before; 0 for the first one.
        counts: (n, n) weight of sighting j < k for where the thing is put at the time of sighting k; 0 elsewhere.
        changes: (n,) entry c: probability of a change between sightings c and c + 1; the last entry: of a change after
            all sightings.
        doubt: weight of the prior expectation, as a number of sightings.
        mistakes: probability that people left the thing anywhere by mistake.
    """
    n = len(places)
    same = counts * (places[:, None] == places[None, :])
    # Entry (k, c) sums sightings c .. k - 1, by cumulating columns from the right.
    total, hits = (np.cumsum(value[:, ::-1], axis=1)[:, ::-1] for value in (counts, same))
    put = (hits + doubt * SPREAD) / (total + doubt)
    put = (1.0 - mistakes) * put + mistakes * SPREAD
    stayed = np.zeros(n)
    stayed[1:] = stays[1:] * (places[1:] == places[:-1])
    log_p = np.log(np.maximum(stayed[:, None] + (1.0 - stays[:, None]) * put, _LEAST))
    k, c = np.indices((n, n))
    before = np.concatenate([[0.0], np.cumsum(log_p[:, 0])])  # log-likelihood of sightings 0 .. c - 1
    after = np.append(np.where(k >= c, log_p, 0.0).sum(0), 0.0)
    none = 1.0 - float(changes.sum())
    prior = np.concatenate([[max(none, 1e-6)], changes])
    score = before + after + np.log(np.maximum(prior, 1e-12))
    p = np.exp(score - score.max())
    return np.asarray(p / p.sum(), np.float64)
