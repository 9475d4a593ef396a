"""From the habits that an agent is given to what it expects, once an episode or again as the list of habits changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from ucon.core.fingerprint import fingerprint_of
from ucon.core.sharing import Shared
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.target_belief import BeliefWeights, Locations, TargetBelief
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.readers.anchor_reader import default_reader
from ucon.readers.protocol import Reader

Info = Mapping[str, Any]
#: Says where the target of an episode may be, from the info at its reset.
Locate = Callable[[Info], Locations]


class ReadHabits(Shared):
    """Locations by a reader: common sense, and what the given habits say."""

    def __init__(self, reader: Reader | None = None) -> None:
        """``reader``: by default the fitted one that is shipped."""
        self._reader = reader

    def fingerprint(self) -> str:
        """Which trained reader reads, see :mod:`ucon.evaluation.playing.needed_weights`; "" for the fitted one."""
        return str(fingerprint_of(self._reader))

    def __call__(self, info: Info) -> Locations:
        """Read ``info["habits"]`` about ``info["target"]``; at level ``gt`` all of them are about it."""
        if self._reader is None:
            self._reader = default_reader()
        target, texts = str(info["target"]), tuple(info["habits"])
        reading = self._reader.read(target, texts, trusted=info.get("habit_level") == "gt")
        belief = reading.belief(self._reader.known)
        where = belief.p[:, None] * belief.relation
        return Locations(belief.candidates, where, texts, reading.telling, reading.support)


def expecting(
    info: Info,
    locate: Locate,
    coverage: CoverageWeights | None = None,
    weights: BeliefWeights | None = None,
    locations: Locations | None = None,
) -> TargetBelief:
    """What to expect in the episode whose info at reset is given; at level ``context`` it reads again as it goes.

    ``locations``: what ``locate`` says of ``info``, where that is known already.
    """
    indifferent = Coverage(str(info["target"]), coverage or CoverageWeights())
    arguments = (locations or locate(info), indifferent, weights or BeliefWeights())
    return ContextBelief(*arguments, info, locate) if "reranking" in info else TargetBelief(*arguments)


class ContextBelief(TargetBelief):
    """At habit level ``context``: says what it saw, and reads the list that comes of it."""

    _shared: ClassVar[frozenset[str]] = TargetBelief._shared | {"_locate"}

    def __init__(
        self, locations: Locations, coverage: Coverage, weights: BeliefWeights, info: Info, locate: Locate
    ) -> None:
        super().__init__(locations, coverage, weights)
        self._info, self._locate = dict(info), locate

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :class:`ucon.perception.belief.protocol.Expecting`."""
        ranking = self._info["reranking"]
        if not ranking.update(known.instances.keys() & self._row.keys(), self._emptied(known, places)):
            return False
        self.believe(self._locate(self._info | {"habits": ranking.texts}))
        return True

    def _emptied(self, known: SemanticMap, places: Places) -> dict[str, float]:
        """Share of each category's belief that was looked at in vain, in tenths: less makes no new list."""
        n = known.n_tracks
        left = np.bincount(places.track, places.weights(self._mass), n)
        whole = np.bincount(places.track, self._mass[places.track, places.relation] * places.share, n)
        out: dict[str, float] = {}
        for name, tracks in known.instances.items():
            total = float(whole[tracks].sum())
            if name in self._row and total > 0.0:
                out[name] = round(1.0 - float(left[tracks].sum()) / total, 1)
        return {name: share for name, share in out.items() if share > 0.0}
