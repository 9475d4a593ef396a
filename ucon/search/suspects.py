"""Suspects: things on the map that may be the target, what speaks for each, and how probable each is.

The arithmetic posterior multiplies the odds of the looks (:mod:`ucon.perception.hypotheses.hypotheses`) by how much
more of the target is expected in the suspect's place than in that of any thing. A judge, a function of the numbers of
:data:`EVIDENCE`, may replace it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors.base import vocabulary
from ucon.perception.errors.model import DetectorErrors
from ucon.perception.hypotheses.hypotheses import Hypotheses, log_prior
from ucon.search.search_decision import Seeking
from ucon.search.suspect_kernels import mass_near

#: Probabilities of m suspects from their evidence (m, F).
Judge = Callable[[NDArray[np.float32]], NDArray[np.float64]]
#: Things that are less probable than this by their looks alone are no suspects.
LEAST: Final = 3e-3
#: Mass expected within this distance of a suspect counts as expected at the suspect, metres.
NEAR_M: Final = 0.4
#: The expected mass multiplies or divides the odds of a suspect by at most this.
MOST_RATIO: Final = 30.0
#: Number of things in a typical home, and how many of them share a place.
THINGS, TOGETHER = 100.0, 3.0
#: The numbers that speak for or against a suspect.
EVIDENCE: Final = (
    "looks", "exists", "called", "called_else", "missed", "best_score", "mean_score", "last_score", "nearest_m",
    "absent", "size_0", "size_1", "size_2", "crowd", "rival", "elsewhere", "step", "commonness", "confused",
    "right", "false_share", "score_gain", "ratio", "ontop", "inside", "under", "nextto", "left",
)  # fmt: skip
#: Those of them that come from the habits.
OF_HABITS: Final = ("ratio", "ontop", "inside", "under", "nextto", "left")


class Suspects(PartlyShared):
    """The suspects of one search, up to date after :meth:`look`.

    Attributes:
        tracks: m track numbers, ascending.
        evidence: (m, F) float32, a column for each of :data:`EVIDENCE`.
        p: by track, the probability that it is the target.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"tracks", "evidence", "p", "_judge"})

    def __init__(self, judge: Judge | None = None) -> None:
        """Start an episode.

        Args:
            judge: gives the probabilities; None: the arithmetic posterior.
        """
        self._judge = judge
        self.tracks: list[int] = []
        self.evidence = np.zeros((0, len(EVIDENCE)), np.float32)
        self.p: dict[int, float] = {}

    def look(self, search: Seeking) -> None:
        """Find the suspects on the map, and weigh the evidence.

        Args:
            search: the search, after it took in a frame and computed the expected mass.
        """
        hypotheses = search.map.hypotheses
        assert hypotheses is not None
        n = search.map.n_tracks
        found = np.flatnonzero(hypotheses.p_target[:n] > LEAST)
        self.tracks = [track for track in found.tolist() if track in hypotheses.looks]
        if not self.tracks:
            self.evidence, self.p = self.evidence[:0], {}
            return
        self.evidence = evidence_of(search, self.tracks)
        p = arithmetic(self.evidence) if self._judge is None else self._judge(self.evidence)
        self.p = dict(zip(self.tracks, p.tolist(), strict=True))


def arithmetic(evidence: NDArray[np.float32]) -> NDArray[np.float64]:
    """The posterior (m,) of suspects by their looks and places alone; see :data:`EVIDENCE`."""
    logit = evidence[:, EVIDENCE.index("looks")].astype(np.float64) + evidence[:, EVIDENCE.index("ratio")]
    return np.asarray(1.0 / (1.0 + np.exp(-logit)))


def evidence_of(search: Seeking, tracks: list[int]) -> NDArray[np.float32]:
    """The evidence for and against each of some things being the target.

    Args:
        search: the search, after it took in a frame and computed the expected mass.
        tracks: m tracks that were found at least once.

    Returns:
        (m, F) float32, a column for each of :data:`EVIDENCE`.
    """
    known, expected, places = search.map, search.expected, search.places
    hypotheses, target = known.hypotheses, search.target
    assert hypotheses is not None
    assert expected is not None
    boxes, of = known.box[tracks], np.array(tracks, np.int32)
    mass, crowd = np.zeros((len(tracks), 4)), np.zeros(len(tracks))
    mass_near(boxes, of, places.xyz, places.track, places.relation, places.share, expected.mass, NEAR_M, mass, crowd)
    mass /= expected.unit
    ratio = np.clip(mass.sum(1) * THINGS / TOGETHER, 1.0 / MOST_RATIO, MOST_RATIO)
    sides = np.log(np.maximum(np.sort(boxes[:, 3:] - boxes[:, :3], axis=1), 0.02)) - _log_sides(target)
    p = np.clip(hypotheses.p_target[tracks], 1e-9, 1.0 - 1e-6)
    second, first = np.sort(np.append(p, [0.0, 0.0]))[-2:].tolist()
    left = np.log(max(float(places.weights(expected.mass).sum()) / expected.unit, 1e-3))
    general, step, every = _of_target(hypotheses.errors, target), known.step / 100.0, float(p.sum())
    rows = np.zeros((len(tracks), len(EVIDENCE)))
    for k, track in enumerate(tracks):
        looks, exists, own = np.log(p[k] / (1.0 - p[k])), hypotheses.exists[track], _own(hypotheses, track, target)
        others = second if p[k] == first else first, min(every - p[k], 3.0)
        place = np.log(ratio[k]), *(mass[k] / max(mass[k].sum(), 1e-9))
        rows[k] = looks, exists, *own, *sides[k], crowd[k], *others, step, *general, *place, left
    return rows.astype(np.float32)


def _own(hypotheses: Hypotheses, track: int, target: str) -> tuple[float, ...]:
    """Counts and scores of a track's looks: ``called`` to ``absent`` of :data:`EVIDENCE`."""
    row = _rows().get(target, -2)
    scores, else_, missed, nearest, last = [], 0, 0, 9.0, 0.0
    for name, score, away_m in hypotheses.looks[track]:
        nearest = min(nearest, away_m)
        if name == row:
            scores.append(score)
        elif name == -1 and score == 0.0:
            missed += 1
        else:
            else_ += 1
        last = score if name == row else -score
    best, mean = (max(scores), sum(scores) / len(scores)) if scores else (0.0, 0.0)
    absent = hypotheses.absent(track)
    return (*np.log1p([len(scores), else_, missed]), best, mean, last, nearest, max(absent, -6.0))


@lru_cache(maxsize=1024)
def _of_target(errors: DetectorErrors, target: str) -> tuple[float, ...]:
    """What is known of a name and a detector: ``commonness`` to ``score_gain`` of :data:`EVIDENCE`."""
    row = _rows().get(target, -1)
    prior = log_prior(errors, -1)
    common = float(prior[row]) if row >= 0 else -12.0
    confused = float(np.log(np.exp(prior.astype(float) + errors.called[:, row]).sum() + 1e-9)) if row >= 0 else -12.0
    return common, confused, errors.right, errors.false_share, errors.evidence(0.9) - errors.evidence(0.3)


@lru_cache(maxsize=2048)
def _log_sides(name: str) -> NDArray[np.float64]:
    """Logarithms of the sides (3,) of a category, ascending."""
    book = catalogue()
    return np.log(np.sort(book[name].size) if name in book else np.full(3, 0.1))


@lru_cache(maxsize=1)
def _rows() -> dict[str, int]:
    """Row of every name in the vocabulary."""
    return {name: k for k, name in enumerate(vocabulary())}
