"""The ``noisy`` detector: the instances in view with the errors of an open-vocabulary detector, without running one.

It misses things (small ones more often), confuses similar categories, reports things where there are none, and its
boxes are inexact. Errors persist, as a real detector's do: they depend on the thing (or the spot), on which of eight
sides it is seen from, and on its distance to a factor of two, but never on the frame. A second look from the same pose
shows the same; walking round a thing may correct an error.

Where the rates come from. *Published* figures, then what was *estimated* from them:

- Recall by size. Published: average recall of Grounding DINO Swin-T on COCO val2017 without training on it, over IoU
  0.5 to 0.95: 0.40 small, 0.66 medium (a user's evaluation, IDEA-Research/GroundingDINO issue 96; AP 0.23, 0.44 and
  0.59 for small, medium and large). Estimated: 0.80 for large. Recall at IoU 0.5 alone is higher by about 1.6 with the
  jitter below, and a threshold that a robot can live with costs about as much again; the two are taken to cancel.
  COCO's sizes (small below 32 x 32 pixels, large from 96 x 96, in about 640 x 480) are taken as shares of the
  picture, 55 and 490 pixels of 128 x 128: a robot's camera is assumed to see as sharply as COCO's.
- False labels. Published: the same detector has AP 0.484 with COCO's 80 names and 0.288 with the 1203 of LVIS minival
  (given as the gains of MM Grounding DINO in its paper, arXiv 2401.02361: +2.2 to 50.6, +12.6 to 41.4). Estimated:
  half of this loss is calling found things by a wrong name, of which the catalogue offers 838: one in five.
- Box jitter. Published: AP at IoU 0.75 is 0.74 of that at 0.5 (0.437 and 0.593, same evaluation). Computed: edges that
  are normally distributed by 7.5 % of the side give the same share. Real errors have longer tails.
- False positives. Estimated, with no figure behind it: 0.3 boxes a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.core.sharing import Shared
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors import noisy_kernels as kernels
from ucon.perception.detectors.base import Frame, vocabulary
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.confusion import wrong_name
from ucon.perception.detectors.tracker import GATE_M
from ucon.perception.mapping.detections import MIN_PIXELS, STRUCTURE_KINDS

#: False positives may appear at the pixels of a GRID x GRID raster.
GRID = 8


@dataclass(frozen=True, slots=True)
class Rates(Shared):
    """How often each error occurs.

    Attributes:
        recall: probability that a thing is found, at each of ``recall_px`` pixels. Interpolated linearly in the
            logarithm of the pixels, constant beyond the ends.
        recall_px: sizes in pixels of the canonical 128 x 128 view, ascending.
        false_labels: probability that a found thing gets a wrong name.
        false_positives: expected boxes on nothing in a frame whose every pixel shows a surface.
        jitter: standard deviation of each edge of a box, as a fraction of the box's side.
    """

    recall: Sequence[float] = (0.2, 0.4, 0.66, 0.8)
    recall_px: Sequence[float] = (4.0, 20.0, 164.0, 1474.0)
    false_labels: float = 0.2
    false_positives: float = 0.3
    jitter: float = 0.075

    def __post_init__(self) -> None:
        shares = (*self.recall, self.false_labels)
        if len(self.recall) != len(self.recall_px) or not self.recall or not all(0.0 <= p <= 1.0 for p in shares):
            raise ConfigError(f"detector.rates={self}: expected chances from 0 to 1, and as many recall as recall_px")
        if min(self.recall_px) <= 0.0 or any(np.diff(self.recall_px) <= 0.0):
            raise ConfigError(f"detector.rates.recall_px={self.recall_px}: expected ascending numbers above 0")
        if not 0.0 <= self.false_positives <= GRID * GRID / 4 or not 0.0 <= self.jitter <= 0.5:
            raise ConfigError(
                f"detector.rates: false_positives={self.false_positives}, jitter={self.jitter}: expected 0 to "
                f"{GRID * GRID // 4} boxes a frame, and 0 to 0.5 sides"
            )

    def found(self, pixels: float) -> float:
        """Probability that a thing of this size is found.

        Args:
            pixels: its size in the canonical 128 x 128 view.
        """
        return float(np.interp(np.log(max(pixels, 1e-9)), np.log(self.recall_px), self.recall))


#: Rates of a detector without errors: for tests, and to measure what boxes instead of pixels cost.
EXACT = Rates(recall=(1.0,), recall_px=(1.0,), false_labels=0.0, false_positives=0.0, jitter=0.0)


@dataclass(frozen=True, slots=True)
class _Look(Shared):
    """Random numbers for one thing (or spot) from one side and distance.

    ``found``, ``wrong``, ``name`` and ``score`` are uniform in [0, 1); ``edges`` (4,) are standard normal.
    """

    found: float
    wrong: float
    name: float
    score: float
    edges: NDArray[np.float64]


class NoisyDetector(BoxDetector):
    """Boxes of the instances in view, with errors at given rates.

    Simulated from the frame's ground truth; needs no colour image.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_rates", "_categories", "_thing"})
    _flat: ClassVar[frozenset[str]] = frozenset({"_looks"})

    name = "noisy"
    needs_rgb = False

    def __init__(
        self, rates: Rates | None = None, *, min_pixels: int = MIN_PIXELS, seed: int = 0, gate_m: float = GATE_M
    ) -> None:
        """Set the errors.

        Args:
            rates: how often each error occurs; the published estimates by default.
            min_pixels: instances with fewer pixels in the canonical 128 x 128 view are never found.
            seed: of the random errors.
            gate_m: of the tracker, metres.
        """
        super().__init__(gate_m)
        self._rates, self._min_pixels, self._seed = rates or Rates(), min_pixels, seed
        self.reset("", ())

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode.

        Args:
            episode: id of the episode; with the seed and the instance it is the key of the random draws.
            categories: category of every instance.
        """
        super().reset(episode, categories)
        self._episode, self._categories = episode, categories
        self._thing = np.array([name not in STRUCTURE_KINDS for name in categories], bool)
        self._looks: dict[tuple[str | int, ...], _Look] = {}

    def find(self, frame: Frame) -> Boxes:
        """Boxes of the things in view by instance number, then false positives.

        Returns:
            Boxes in the frame's pixels; edges may lie outside the frame.
        """
        labels: list[str] = []
        scores: list[float] = []
        boxes: list[NDArray[np.float64]] = []
        for label, score, box in (*self._things(frame), *self._ghosts(frame)):
            labels.append(label)
            scores.append(score)
            boxes.append(box)
        if not labels:
            return Boxes.none()
        return Boxes(labels, np.array(scores, np.float32), np.array(boxes, np.float32))

    def _things(self, frame: Frame) -> list[tuple[str, float, NDArray[np.float64]]]:
        """Label, score and box (4,) of every instance that is found in this frame."""
        n = len(frame.counts)
        box, middle, count = np.empty((n, 4), np.int32), np.empty((n, 3)), np.empty(n, np.int32)
        kernels.outline(frame.depth, frame.instance, frame.camera, box, middle, count)
        away = middle - (frame.pose[0], frame.pose[1], frame.camera_m)
        side = np.floor(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4)).astype(int) % 8
        octave = np.round(np.log2(np.maximum(np.linalg.norm(away, axis=1), 0.1))).astype(int)
        found = []
        for k in np.flatnonzero((frame.counts >= self._min_pixels) & (count > 0) & self._thing).tolist():
            look, sure = self._look("thing", k, int(side[k]), int(octave[k])), self._rates.found(int(frame.counts[k]))
            if look.found >= sure:
                continue
            wrong = look.wrong < self._rates.false_labels
            name = self._categories[k]
            # Scores are lower for small things and for wrong names (estimated).
            score = (0.3 if wrong else 0.3 + 0.4 * sure) + 0.2 * look.score
            found.append((wrong_name(name, look.name) if wrong else name, score, self._shaken(box[k], look)))
        return found

    def _ghosts(self, frame: Frame) -> list[tuple[str, float, NDArray[np.float64]]]:
        """False positives: label, score and box (4,).

        Every raster pixel has the same chance. Pixels that show one spot from one side share one draw.
        """
        spot, pixel = np.empty((GRID * GRID, 4), np.int32), np.empty((GRID * GRID, 2), np.int32)
        chance = self._rates.false_positives / (GRID * GRID)
        if chance == 0.0:
            return []
        shown = kernels.spots(frame.depth, frame.camera, GRID, spot, pixel)
        rows, first, pixels = np.unique(spot[:shown], axis=0, return_index=True, return_counts=True)
        names, book, focal_px = vocabulary(), catalogue(), frame.camera[7]
        found = []
        for row, k, n in zip(rows.tolist(), first.tolist(), pixels.tolist(), strict=True):
            look = self._look("spot", *row)
            if look.found >= n * chance:
                continue
            name = names[int(look.name * len(names))]
            u, v = pixel[k]
            _, middle, large = sorted(book[name].size)
            half = np.clip(0.5 * focal_px / frame.depth[v, u] * np.array([middle, large]), 2.0, 24.0)
            box = np.array([u - half[0], v - half[1], u + half[0], v + half[1]])
            found.append((name, 0.3 + 0.2 * look.score, box))
        return found

    def _look(self, *key: str | int) -> _Look:
        """The random numbers of a key, drawn once an episode."""
        look = self._looks.get(key)
        if look is None:
            rng = stream(self._seed, "noisy", self._episode, *key)
            found, wrong, name, score = rng.random(4).tolist()
            look = self._looks[key] = _Look(found, wrong, name, score, rng.standard_normal(4))
        return look

    def _shaken(self, box: NDArray[np.int32], look: _Look) -> NDArray[np.float64]:
        """The box (4,) with jittered edges."""
        side = np.tile(box[2:] - box[:2], 2)
        return box + self._rates.jitter * side * look.edges
