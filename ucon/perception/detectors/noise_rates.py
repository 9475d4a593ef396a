"""How often the ``noisy`` detector errs, and where the rates come from.

*Published* figures, and what was *estimated* or *computed* from them:

- Recall by size. Published: average recall of Grounding DINO Swin-T on COCO val2017 without training on it, over IoU
  0.5 to 0.95: 0.40 small, 0.66 medium (a user's evaluation, IDEA-Research/GroundingDINO issue 96; AP 0.23, 0.44 and
  0.59 for small, medium and large). Estimated: 0.80 for large. Recall at IoU 0.5 alone is higher by about 1.6 with the
  jitter below, and a threshold that a robot can live with costs about as much again; the two are taken to cancel.
  COCO's sizes (small below 32 x 32 pixels, large from 96 x 96, in about 640 x 480) are taken as shares of the
  picture, 55 and 490 pixels of 128 x 128: a robot's camera is assumed to see as sharply as COCO's.
- Recall by occlusion and range. Estimated, with no figure behind it: a thing of which 35 % shows is found 0.7 times as
  often as one that shows whole, and one at 8 m 0.7 times as often as one of as many pixels within 3 m. Computed: over
  the frames of walks through homes the two factors together are 0.63, 0.68, 0.80 and 0.92 at the four sizes on average;
  the recall of a thing that shows whole is the published average over that.
- False labels. Published: the same detector has AP 0.484 with COCO's 80 names and 0.288 with the 1203 of LVIS minival
  (given as the gains of MM Grounding DINO in its paper, arXiv 2401.02361: +2.2 to 50.6, +12.6 to 41.4). Estimated:
  half of this loss is calling found things by a wrong name, of which the catalogue offers 838: one in five.
- Scores. Published: the scores of YOLOv3 tell right boxes from wrong ones with an AUROC of about 0.83 on COCO's 80
  names (quoted from memory, not checked against the paper's tables), and boxes below 0.3 "cannot be reliably
  separated" by them (Riedlinger et al., Gradient-based quantification of epistemic uncertainty for deep object
  detectors, arXiv 2107.04517); the scores of YOLO-World are poorly calibrated
  (Applied Sciences 15(22), 12062). Estimated: 0.80 among 838 names. Scores are drawn from two normal distributions of
  one width whose distance gives this AUROC, at every size and distance; the sizes move both alike.
- Box jitter. Published: AP at IoU 0.75 is 0.74 of that at 0.5 (0.437 and 0.593, same evaluation). Computed: edges that
  are normally distributed by 7.5 % of the side give the same share. Real errors have longer tails.
- False positives. Estimated, with no figure behind it: 0.3 boxes a frame.

``noisy_low`` and ``noisy_high`` are the two ends of what the estimates leave open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.sharing import Shared

#: False positives may appear at the pixels of a GRID x GRID raster.
GRID = 8
#: Boxes with a lower score are not reported.
LEAST_SCORE = 0.25


@dataclass(frozen=True, slots=True)
class Rates(Shared):
    """How often each error occurs. A thing is found with probability recall x hidden x far.

    Attributes:
        recall: probability that a near thing that shows whole is found, at each of ``recall_px`` pixels. Interpolated
            linearly in the logarithm of the pixels, constant beyond the ends.
        recall_px: sizes in pixels of the canonical 128 x 128 view, ascending.
        hidden: factor of the recall where only a share of the thing shows, at each of ``hidden_share``. Linear between.
        hidden_share: pixels that show over those that a thing of its catalogue size would have there, ascending.
        far: factor of the recall at each of ``far_m``. Linear between.
        far_m: distances in metres, ascending.
        false_labels: probability that a found thing gets a wrong name.
        false_positives: expected boxes on nothing in a frame whose every pixel shows a surface.
        auroc: probability that a right box has a higher score than a box with a wrong name or on nothing.
        jitter: standard deviation of each edge of a box, as a fraction of the box's side.

    Raises:
        ConfigError: at construction, if a rate is out of its range.
    """

    recall: Sequence[float] = (0.32, 0.6, 0.82, 0.88)
    recall_px: Sequence[float] = (4.0, 20.0, 164.0, 1474.0)
    hidden: Sequence[float] = (0.3, 0.7, 1.0)
    hidden_share: Sequence[float] = (0.1, 0.35, 0.7)
    far: Sequence[float] = (1.0, 0.7)
    far_m: Sequence[float] = (3.0, 8.0)
    false_labels: float = 0.2
    false_positives: float = 0.3
    auroc: float = 0.8
    jitter: float = 0.075

    def __post_init__(self) -> None:
        for name, positions in (("recall", "recall_px"), ("hidden", "hidden_share"), ("far", "far_m")):
            chances, at = getattr(self, name), getattr(self, positions)
            if len(chances) != len(at) or not chances or not all(0.0 <= p <= 1.0 for p in chances):
                raise ConfigError(
                    f"detector.rates.{name}={chances}: expected probabilities from 0 to 1, as many as {positions}={at}"
                )
            if min(at) <= 0.0 or any(np.diff(at) <= 0.0):
                raise ConfigError(f"detector.rates.{positions}={at}: expected ascending numbers above 0")
        if not 0.0 <= self.false_labels <= 1.0 or not 0.5 <= self.auroc < 1.0:
            raise ConfigError(
                f"detector.rates: false_labels={self.false_labels}, auroc={self.auroc}: expected 0 to 1, and 0.5 to "
                "below 1"
            )
        if not 0.0 <= self.false_positives <= GRID * GRID / 4 or not 0.0 <= self.jitter <= 0.5:
            raise ConfigError(
                f"detector.rates: false_positives={self.false_positives}, jitter={self.jitter}: expected 0 to "
                f"{GRID * GRID // 4} boxes a frame, and 0 to 0.5 sides"
            )

    @property
    def apart(self) -> float:
        """Distance between the two score distributions, in their standard deviations."""
        return 2.0**0.5 * NormalDist().inv_cdf(self.auroc)

    def curves(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The factors of the recall by logarithm of the pixels, share in view and distance: each (2, n), x and y."""
        sizes = np.array([np.log(self.recall_px), self.recall], np.float64)
        shares = np.array([self.hidden_share, self.hidden], np.float64)
        return sizes, shares, np.array([self.far_m, self.far], np.float64)


#: Rates of a detector without errors: for tests, and to measure what boxes instead of pixels cost.
EXACT = Rates((1.0,), (1.0,), (1.0,), (1.0,), (1.0,), (1.0,), false_labels=0.0, false_positives=0.0, jitter=0.0)
