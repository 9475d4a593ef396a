"""The ``noisy`` detector: the instances in view with the errors of an open-vocabulary detector, without running one.

It misses things (small, hidden and distant ones more often), confuses similar categories, and reports things where
there are none. Its scores separate right from wrong boxes only partly, and its boxes are inexact. Errors persist, as a
real detector's do: they depend on the thing (or the spot), on which of eight sides it is seen from, and on its distance
to within a factor of two, but never on the frame. A second look from the same pose shows the same; walking round a
thing may correct an error.

Where the rates come from: :mod:`ucon.perception.detectors.noise_rates`.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import derived_seed
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors import noisy_kernels as kernels
from ucon.perception.detectors.base import Frame, vocabulary
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.confusion import wrong_name
from ucon.perception.detectors.noise_rates import GRID, LEAST_SCORE, Rates
from ucon.perception.mapping.detections import MIN_PIXELS, STRUCTURE_KINDS
from ucon.perception.tracking.tracker import GATE_M
from ucon.sim.render.base import VIEW_PX, tan_half


class NoisyDetector(BoxDetector):
    """Boxes of the instances in view, with errors at given rates.

    Simulated from the frame's ground truth; needs no colour image.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_rates", "_curves", "_categories", "_surface_m2"})

    needs_rgb = False

    def __init__(
        self,
        rates: Rates | None = None,
        *,
        name: str = "noisy",
        min_pixels: int = MIN_PIXELS,
        seed: int = 0,
        gate_m: float = GATE_M,
        errors: str | None = None,
    ) -> None:
        """Set the errors.

        Args:
            rates: how often each error occurs; the published estimates by default.
            name: of the detector with errors of this strength.
            min_pixels: instances with fewer pixels in the canonical 128 x 128 view are never found.
            seed: of the random errors.
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with its errors; None: those that come with the package, where there are any.
        """
        super().__init__(gate_m, errors)
        self.name = name
        self._rates, self._min_pixels, self._seed = rates or Rates(), min_pixels, seed
        self._curves = self._rates.curves()
        self.reset("", ())

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode.

        Args:
            episode: id of the episode; with the seed and the instance it is the key of the random draws.
            categories: category of every instance.
        """
        super().reset(episode, categories)
        self._key = derived_seed(self._seed, "noisy", episode)
        self._categories = categories
        self._surface_m2 = np.array([_surface_m2(name) for name in categories])
        n = len(categories)
        self._outlines = np.empty((n, 4), np.int32), np.empty((n, 3)), np.empty(n, np.int32)
        self._found = np.empty(n, np.int32), np.empty(n), np.empty(n), np.empty((n, 4))
        cells = GRID * GRID
        self._spots = np.empty(cells, np.uint64), np.empty((cells, 2), np.int32)
        self._false = np.empty((cells, 2), np.int32), np.empty(cells), np.empty(cells)

    def find(self, frame: Frame) -> Boxes:
        """Boxes of the things in view by instance number, then false positives.

        Returns:
            Boxes in the frame's pixels; edges may lie outside the frame.
        """
        camera = frame.camera
        things = self._things(frame, camera)
        n = len(things)
        false = self._false_boxes(frame, camera)
        if not things and not false:
            return Boxes.none()
        score = np.concatenate([self._found[2][:n], [s for _, s, _ in false]])
        box = np.concatenate([self._found[3][:n], np.array([b for _, _, b in false]).reshape(-1, 4)])
        return Boxes([*things, *(name for name, _, _ in false)], score.astype(np.float32), box.astype(np.float32))

    def _things(self, frame: Frame, camera: NDArray[np.float64]) -> list[str]:
        """Names given to the n instances that are found in this frame.

        The first n rows of ``_found`` are their instances, draws of the name, scores and boxes.
        """
        rates = self._rates
        kernels.outline(frame.depth, frame.instance, camera, *self._outlines)
        focal_px = 0.5 * VIEW_PX / tan_half(frame.counts_fov_deg)
        chances = (rates.false_labels, rates.apart, rates.jitter, LEAST_SCORE, float(self._min_pixels), focal_px)
        n = kernels.things(
            self._key, camera, frame.counts, self._surface_m2, self._outlines, self._curves, chances, self._found
        )
        instance, name = self._found[0][:n].tolist(), self._found[1][:n].tolist()
        truth = [self._categories[k] for k in instance]
        return [right if draw < 0.0 else wrong_name(right, draw) for right, draw in zip(truth, name, strict=True)]

    def _false_boxes(self, frame: Frame, camera: NDArray[np.float64]) -> list[tuple[str, float, NDArray[np.float64]]]:
        """False positives: label, score and box (4,)."""
        chances = (self._rates.false_positives / (GRID * GRID), self._rates.apart, LEAST_SCORE)
        if chances[0] == 0.0:
            return []
        n = kernels.false_boxes(self._key, frame.depth, camera, GRID, chances, *self._spots, self._false)
        names, book, focal_px = vocabulary(), catalogue(), float(camera[7])
        found = []
        for (u, v), draw, score in zip(*(rows[:n].tolist() for rows in self._false), strict=True):
            name = names[int(draw * len(names))]
            _, middle, large = sorted(book[name].size)
            half = np.clip(0.5 * focal_px / frame.depth[v, u] * np.array([middle, large]), 2.0, 24.0)
            found.append((name, score, np.array([u - half[0], v - half[1], u + half[0], v + half[1]])))
        return found


def _surface_m2(name: str) -> float:
    """Surface in square metres of a box of a category's catalogue size; 0 for structure."""
    book = catalogue()
    if name in STRUCTURE_KINDS:
        return 0.0
    x, y, z = book[name].size if name in book else (0.1, 0.1, 0.1)
    return 2.0 * float(x * y + x * z + y * z)
