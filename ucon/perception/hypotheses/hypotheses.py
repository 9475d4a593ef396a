"""Every 3-D box on the map is a hypothesis: a posterior over names, and a probability that there is a thing at all.

Looks that err together (one side, one distance) count once. The name that the detector gives a thing counts by the
detector's confusions and by the score; a look that should have shown a thing and did not is evidence against it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import vocabulary
from ucon.perception.errors.model import DetectorErrors
from ucon.perception.hypotheses.look_kernels import FOUND, MOST_OCTAVES, look_key, new_looks

#: Things farther away are not expected to be found, metres.
REACH_M = 6.0
#: Expected number of things of a name in a home, where training homes had none.
_UNHEARD = 0.004
#: A box counts as a thing from this probability on.
_LEAST = 0.5


class Hypotheses(PartlyShared):
    """The hypotheses of one episode: what its tracks may be.

    Attributes:
        errors: of the detector.
        exists: (>= T,) float64, probability that there is a thing.
        p_target: (>= T,) float64, probability that it is there and has the target's name, whatever its place.
        looks: by track, its looks from new sides and distances: name (row of the vocabulary; -1 for a name outside it,
            and with score 0 for a look in vain), score, distance in metres.
    """

    _flat: ClassVar[frozenset[str]] = frozenset(
        {"exists", "p_target", "_evidence", "_log_p", "_absent", "_found", "_state", "_lost"}
    )
    _shared: ClassVar[frozenset[str]] = frozenset({"_prior"})

    def __init__(self, errors: DetectorErrors, target: str) -> None:
        """Start without tracks.

        Args:
            errors: of the detector.
            target: category of the target; one more thing of it is expected in the home.
        """
        self.errors = errors
        self._target = name_rows().get(target, -1)
        self._prior = log_prior(errors, self._target)
        self._keys = errors.sides * MOST_OCTAVES
        n, names = 64, len(vocabulary())
        self.exists, self.p_target = np.zeros(n), np.zeros(n)
        self.looks: dict[int, list[tuple[int, float, float]]] = {}
        self._evidence, self._log_p = np.zeros((n, names), np.float32), np.full((n, names), -np.inf, np.float32)
        self._absent, self._found = np.zeros(n), np.zeros(n)
        self._state = np.zeros((n, self._keys), np.uint8)
        self._lost: dict[tuple[int, int], float] = {}

    def search_again(self, target: str, stale: list[int]) -> None:
        """Begin another search in the same home.

        Args:
            target: what is searched for now.
            stale: tracks of things that may have been moved: what was seen of them no longer counts.
        """
        self._target = name_rows().get(target, -1)
        self._prior = log_prior(self.errors, self._target)
        self.forget(stale)
        self.p_target[:] = 0.0
        self._judge(np.array(sorted(self.looks), np.int32), [])

    def forget(self, tracks: list[int]) -> None:
        """Drop all that was seen of some tracks."""
        self._reserve(max(tracks, default=0) + 1)
        for column in (self._evidence, self._absent, self._found, self._state, self.exists, self.p_target):
            column[tracks] = 0
        self._log_p[tracks] = -np.inf
        for track in tracks:
            self.looks.pop(track, None)
        self._lost = {key: lost for key, lost in self._lost.items() if key[0] in self.looks}

    def support(self, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """How often tracks were found from new sides, and the log probability that all looks in vain missed them.

        Args:
            n: number T of tracks.

        Returns:
            (T,) and (T,).
        """
        self._reserve(n)
        return self._found[:n].copy(), self._absent[:n].copy()

    def _reserve(self, n: int) -> None:
        """Make room for n tracks."""
        if n > len(self.exists):
            for name in ("exists", "p_target", "_evidence", "_log_p", "_absent", "_found", "_state"):
                column = getattr(self, name)
                blank = np.full(
                    (2 * n - len(column), *column.shape[1:]), -np.inf if name == "_log_p" else 0, column.dtype
                )
                setattr(self, name, np.concatenate([column, blank]))

    def look(
        self,
        box: NDArray[np.float64],
        kind: NDArray[np.uint8],
        category: list[str],
        called: dict[int, tuple[str, float]],
        depth: NDArray[np.float32],
        camera: NDArray[np.float64],
    ) -> dict[int, str]:
        """Take in one frame.

        Args:
            box: (T, 6) float64, boxes of the tracks, metres.
            kind: (T,) uint8, 0 for things.
            category: their most probable names so far, "" where there is none.
            called: names and scores of the tracks that the detector found in this frame.
            depth: (H, W) float32, metres along the optical axis.
            camera: (8,) float64.

        Returns:
            By track, the most probable name where it changed; "" where there is probably no thing.
        """
        n = len(kind)
        self._reserve(n)
        named = np.zeros(n, np.uint8)
        named[list(called)] = 1
        event, away_m = np.empty((n, 3), np.int32), np.empty(n)
        errors = self.errors
        count = new_looks(
            box,
            kind,
            named,
            depth,
            camera,
            errors.sides,
            limits_m2(errors.octave),
            REACH_M,
            self._state[:n],
            event,
            away_m,
        )
        if not count:
            return {}
        for (track, key, what), away in zip(event[:count].tolist(), away_m[:count].tolist(), strict=True):
            if what == FOUND:
                name, score = called[track]
                self._add(track, key, name_rows().get(name, -1), score, away)
            elif track in self.looks:
                self._miss(track, key, category[track], away)
        return self._judge(np.unique(event[:count, 0]), category)

    def named(self, names: tuple[str, ...], n: int) -> NDArray[np.float64]:
        """Probability that tracks are there and have some names.

        Args:
            names: A names.
            n: number T of tracks.

        Returns:
            (T, A) float64; 0 for names outside the vocabulary, and for tracks that were never found.
        """
        rows = np.array([name_rows().get(name, -1) for name in names])
        out = np.exp(self._log_p[:n, rows].astype(np.float64)) * self.exists[:n, None]
        out[:, rows < 0] = 0.0
        return out

    def absent(self, track: int) -> float:
        """Log probability that all looks in vain at a track missed it, if it is there."""
        return float(self._absent[track])

    def state_from(self, track: int, dx: float, dy: float, dz: float) -> int:
        """Whether a track was looked at from a side and distance: ``NEVER``, ``MISSED`` or ``FOUND``.

        Args:
            track: its number.
            dx: from the camera to the middle of its box along x, metres.
            dy: the same along y.
            dz: the same upwards.
        """
        return int(self._state[track, look_key(dx, dy, dz, self.errors.sides, limits_m2(self.errors.octave))])

    def _add(self, track: int, key: int, name: int, score: float, away: float) -> None:
        """Count a look that found a thing of a name."""
        self.looks.setdefault(track, []).append((name, score, away))
        self._absent[track] -= self._lost.pop((track, key), 0.0)
        if name < 0:
            return
        row = self._evidence[track]
        before = float(row[name])
        row += _called_so(self.errors)[name]
        row[name] = before + np.log(max(self.errors.right, 1e-6)) + self.errors.evidence(score)
        self._found[track] += 1

    def _miss(self, track: int, key: int, category: str, away: float) -> None:
        """Count a look that should have found a thing."""
        chance = float(self.errors.sighted_curve(category, np.array([away]))[0])
        self._lost[track, key] = lost = float(np.log(max(1.0 - chance, 1e-3)))
        self._absent[track] += lost
        self.looks[track].append((-1, 0.0, away))

    def _judge(self, tracks: NDArray[np.int32], category: list[str]) -> dict[int, str]:
        """Compute the posterior of some tracks; returns the names that changed from ``category``, if that is given."""
        log_p = self._prior + self._evidence[tracks]
        best = log_p.argmax(1)
        top = log_p.max(1)
        whole = top + np.log(np.exp(log_p - top[:, None]).sum(1))
        share = min(max(self.errors.false_share, 1e-6), 0.5)
        ghost = np.log(share / (1.0 - share)) - self._found[tracks] * np.log(len(vocabulary()))
        self._log_p[tracks] = log_p - whole[:, None]
        self.exists[tracks] = exists = 1.0 / (1.0 + np.exp(np.clip(ghost - whole - self._absent[tracks], -50.0, 50.0)))
        if self._target >= 0:
            self.p_target[tracks] = exists * np.exp(log_p[:, self._target] - whole)
        names = vocabulary()
        changed = {}
        for track, k, there in zip(tracks.tolist(), best.tolist(), exists.tolist(), strict=True):
            if category and track in self.looks:
                name = names[k] if there >= _LEAST and self._found[track] else ""
                if name != category[track]:
                    changed[track] = name
        return changed


@lru_cache(maxsize=8)
def limits_m2(octave: float) -> NDArray[np.float64]:
    """Squares of the distances in metres, ascending, between which looks err together.

    Args:
        octave: each distance is two to the power of this times the last; at 1 they go from 0.35 to 23 m.
    """
    return np.asarray(4.0 ** (octave * (np.arange(MOST_OCTAVES - 1) - 1.5)))


@lru_cache(maxsize=1)
def name_rows() -> dict[str, int]:
    """Row of every name in the vocabulary of detectors."""
    return {name: k for k, name in enumerate(vocabulary())}


@lru_cache(maxsize=4)
def _called_so(errors: DetectorErrors) -> NDArray[np.float32]:
    """(V, V) float32: log probability that a thing of every other name (column) is wrongly called by a name (row)."""
    return np.ascontiguousarray(errors.called.T + np.float32(np.log(max(1.0 - errors.right, 1e-6))))


@lru_cache(maxsize=1024)
def log_prior(errors: DetectorErrors, target: int) -> NDArray[np.float32]:
    """(V,) float32, logarithms of the names' shares among the things of a home that has the target."""
    count = np.full(len(vocabulary()), _UNHEARD)
    for name, n in zip(errors.names, errors.counts, strict=True):
        if name in name_rows():
            count[name_rows()[name]] += n
    if target >= 0:
        count[target] += 1.0
    return np.asarray(np.log(count / count.sum()), np.float32)
