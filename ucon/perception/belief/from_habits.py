"""Turns the habits that an agent is given into its belief about the target's place.

Habits are read once at the reset. At habit level ``context`` they are read again whenever the list of habits changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.fingerprint import fingerprint_of
from ucon.core.sharing import Shared
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.target_belief import BeliefWeights, Locations, TargetBelief
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.readers.anchor_reader import default_reader
from ucon.readers.protocol import Reader, read_info

Info = Mapping[str, Any]
#: Cases less probable than this are left out.
_LEAST_PROBABLE = 1e-6
#: A function from the info at an episode's reset to the distribution over the target's anchor and relation.
Locate = Callable[[Info], Locations]


class ReadHabits(Shared):
    """Reads habits into a distribution over anchors and relations; a prior of common places fills the gaps.

    An instance is a :data:`Locate`. Configurations name it as ``locate``.
    """

    def __init__(self, reader: Reader | None = None) -> None:
        """Choose the reader.

        Args:
            reader: what scores anchors from sentences. By default the fitted reader that is shipped, loaded at first
                use.
        """
        self._reader = reader

    def fingerprint(self) -> str:
        """Checksum of the reader's trained weights, "" for the fitted reader that is shipped.

        It goes into the run's record (:mod:`ucon.evaluation.playing.needed_weights`).
        """
        return str(fingerprint_of(self._reader))

    def __call__(self, info: Info) -> Locations:
        """Read ``info["habits"]`` about ``info["target"]``, in the context ``info["told"]`` where there is one.

        At habit level ``gt`` the reader knows that all habits are about the target. Where ``info["habits_valid"]``
        gives the probability that each habit has not changed since it was told, the belief is a mixture over the sets
        of habits that may still hold.

        Returns:
            Joint probability (A, 4) of anchor and relation, with the H habits, their relevance and their support.
        """
        texts, valid = tuple(info["habits"]), info.get("habits_valid")
        found = self._read(info)
        if valid is None or (valid >= 1.0).all():
            return found
        parts = [
            p * (found if len(rows) == len(texts) else self._read({**info, "habits": [texts[row] for row in rows]})).p
            for p, rows in _since_told(valid)
        ]
        support, relevance = found.support, found.relevance
        assert support is not None
        assert relevance is not None
        return Locations(
            found.names, np.sum(parts, axis=0), texts, relevance * valid, lambda anchor: support(anchor) * valid
        )

    def _read(self, info: Info) -> Locations:
        """What the habits say if all of them hold."""
        if self._reader is None:
            self._reader = default_reader()
        texts, reading = tuple(info["habits"]), read_info(self._reader, info)
        belief = reading.belief(self._reader.known)
        where = belief.p[:, None] * belief.relation
        return Locations(belief.candidates, where, texts, reading.telling, reading.support)


def _since_told(valid: NDArray[np.float64]) -> Iterator[tuple[float, NDArray[np.int64]]]:
    """Cases of the mixture: probability, and rows of habits that still hold. A change ends all habits told before it.

    Args:
        valid: (H,) probability that each habit has not changed since it was told.
    """
    before = 0.0
    for level in (*np.unique(valid).tolist(), 1.0):
        if level - before > _LEAST_PROBABLE:
            yield level - before, np.flatnonzero(valid >= level) if level in valid else np.zeros(0, np.int64)
        before = level


def expecting(
    info: Info,
    locate: Locate,
    coverage: CoverageWeights | None = None,
    weights: BeliefWeights | None = None,
    locations: Locations | None = None,
) -> TargetBelief:
    """Make the belief of one episode.

    Args:
        info: the info at the reset. With the key ``reranking`` (habit level ``context``) the belief reads the habits
            again whenever their list changes.
        locate: reads the habits of an info.
        coverage: weights of the part of the belief that follows coverage; defaults where None.
        weights: how the distribution is spread over the map; defaults where None.
        locations: the result of ``locate(info)``, where it was computed already.

    Returns:
        A belief that implements :class:`ucon.perception.belief.protocol.Expecting`.
    """
    by_coverage = Coverage(str(info["target"]), coverage or CoverageWeights())
    arguments = (locations or locate(info), by_coverage, weights or BeliefWeights())
    return ContextBelief(*arguments, info, locate) if "reranking" in info else TargetBelief(*arguments)


class ContextBelief(TargetBelief):
    """The belief at habit level ``context``: reports what was seen, and reads the re-ranked list of habits."""

    _shared: ClassVar[frozenset[str]] = TargetBelief._shared | {"_locate"}

    def __init__(
        self, locations: Locations, coverage: Coverage, weights: BeliefWeights, info: Info, locate: Locate
    ) -> None:
        """As :class:`TargetBelief`, plus ``info`` of the reset (for its ``reranking``) and the reader ``locate``."""
        super().__init__(locations, coverage, weights)
        self._info, self._locate = dict(info), locate

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Report the anchors seen, and those found empty, to the re-ranking; read the list again if it changed.

        Args:
            known: the map so far.
            places: what was looked at.

        Returns:
            Whether the distribution over anchors changed.
        """
        ranking = self._info["reranking"]
        if not ranking.update(known.instances.keys() & self._row.keys(), self._emptied(known, places)):
            return False
        self.believe(self._locate(self._info | {"habits": ranking.texts}))
        return True

    def _emptied(self, known: SemanticMap, places: Places) -> dict[str, float]:
        """Share of each anchor category's mass that was looked at without finding the target, above 0.

        Rounded to tenths, so that small changes make no new list of habits.
        """
        n = known.n_tracks
        left = np.bincount(places.track, places.weights(self._mass), n)
        whole = np.bincount(places.track, self._mass[places.track, places.relation] * places.share, n)
        out: dict[str, float] = {}
        for name, tracks in known.instances.items():
            total = float(whole[tracks].sum())
            if name in self._row and total > 0.0:
                out[name] = round(1.0 - float(left[tracks].sum()) / total, 1)
        return {name: share for name, share in out.items() if share > 0.0}
