"""Since when a thing has been kept as it is kept now: the posterior over the change point in what was seen of it.

Sightings before a change say nothing of where the thing is put now. By every hypothesis (no change, or a change between
two sightings, or after the last one) the sightings since then are predicted one after the other; how well that goes,
and how probable a change is on each day, gives the posterior.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Probability of a given place by the told habits and common sense, for places that were not seen since the change.
SPREAD = 0.1
#: Least probability of a sighting: two in one slot may contradict each other.
_LEAST = 1e-3

Array = NDArray[np.float64]


def change_posterior(
    places: NDArray[np.int64], stays: Array, counts: Array, changes: Array, doubt: float, mistakes: float
) -> Array:
    """Probability (n + 1,) that the n sightings from number c on are of the way in which the thing is kept now.

    Args:
        places: (n,) place of every sighting, in order.
        stays: (n,) probability that nobody used the thing since the sighting before; 0 for the first one.
        counts: (n, n) what sighting j < k counts for where the thing is put at the time of sighting k; 0 elsewhere.
        changes: (n,) probability of a change between the sighting before c + 1 and that one, for c = 0 .. n - 1; the
            last is of a change after all sightings.
        doubt: weight of what was expected before, as a number of sightings.
        mistakes: probability that a sighting is a mistake of people, anywhere.
    """
    n = len(places)
    same = counts * (places[:, None] == places[None, :])
    # (k, c): by sightings c .. k - 1; columns from the right.
    total, hits = (np.cumsum(value[:, ::-1], axis=1)[:, ::-1] for value in (counts, same))
    put = (hits + doubt * SPREAD) / (total + doubt)
    put = (1.0 - mistakes) * put + mistakes * SPREAD
    stayed = np.zeros(n)
    stayed[1:] = stays[1:] * (places[1:] == places[:-1])
    log_p = np.log(np.maximum(stayed[:, None] + (1.0 - stays[:, None]) * put, _LEAST))
    k, c = np.indices((n, n))
    before = np.concatenate([[0.0], np.cumsum(log_p[:, 0])])  # of sightings 0 .. c - 1, without a change
    after = np.append(np.where(k >= c, log_p, 0.0).sum(0), 0.0)
    none = 1.0 - float(changes.sum())
    prior = np.concatenate([[max(none, 1e-6)], changes])
    score = before + after + np.log(np.maximum(prior, 1e-12))
    p = np.exp(score - score.max())
    return np.asarray(p / p.sum(), np.float64)
