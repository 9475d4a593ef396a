"""The chance that a look from a distance shows the target, by the errors of the detector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.perception.errors.model import DetectorErrors
from ucon.perception.hypotheses.hypotheses import limits_m2
from ucon.perception.places.chance_kernels import STEP_M

#: Looks from farther away than this count for nothing, metres.
FARTHEST_M: Final = 6.0
#: Looks with a smaller chance than LEAST_CHANCE count for nothing, unless from nearer than NEAR_M, metres.
LEAST_CHANCE, NEAR_M = 0.25, 1.0
#: A search passes most places several times, so each look counts as this many.
PASSES: Final = 3.0


@dataclass(frozen=True, eq=False)
class Sight(Shared):
    """Chances that a look shows the target, and which looks err together.

    Attributes:
        model: chances (k,) at every ``STEP_M``, sides and limits, as the kernels take them.
    """

    model: tuple[NDArray[np.float64], int, NDArray[np.float64]]

    @classmethod
    def of(cls, errors: DetectorErrors, target: str, passes: float = PASSES) -> Sight:
        """The sight of a target.

        Args:
            errors: of the detector.
            target: its name.
            passes: each look counts as this many.
        """
        away_m: NDArray[np.float64] = STEP_M * np.arange(int(FARTHEST_M / STEP_M), dtype=np.float64)
        chance = errors.right * errors.sighted_curve(target, np.maximum(away_m, STEP_M))
        counts = np.flatnonzero((chance > LEAST_CHANCE) | (away_m < NEAR_M))
        chance = 1.0 - (1.0 - chance) ** passes
        return cls((chance[: int(counts[-1]) + 1], errors.sides, limits_m2(errors.octave)))
