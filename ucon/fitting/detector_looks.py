"""Looks of a detector at things whose truth is known; its errors are fitted on them.

A walk follows the solution of a training episode, with a turn on the spot every few steps. Boxes are matched with the
simulator's instances by overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors.base import Frame, vocabulary
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes, overlap
from ucon.perception.detectors.noisy_kernels import outline
from ucon.perception.errors.model import whole_pixels
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections
from ucon.task.actions import Action
from ucon.task.episode import Episode

#: A box belongs to the thing that it overlaps most, if by at least this much (intersection over union).
LEAST_OVERLAP = 0.3
#: Steps along the way between two turns on the spot.
_BETWEEN_TURNS = 3


@dataclass(frozen=True)
class Looks:
    """n looks at things; all arrays have one row for each."""

    home: NDArray[np.int32]
    """Number of the episode."""
    thing: NDArray[np.int32]
    """The simulator's instance."""
    name: NDArray[np.int32]
    """Row of its name in the vocabulary; -1 for names outside."""
    pixels: NDArray[np.float64]
    """Visible pixels in the canonical view."""
    whole: NDArray[np.float64]
    """Pixels that a thing of its catalogue size has there."""
    away_m: NDArray[np.float64]
    """Distance of its visible part, metres."""
    bearing: NDArray[np.float64]
    """Direction from the camera to it over the floor, radians in the start frame."""
    found: NDArray[np.bool_]
    """Whether a box was matched with it."""
    called: NDArray[np.int32]
    """Row of the box's name; -1 where there is none."""
    score: NDArray[np.float64]
    """The box's score; 0 where there is none."""

    def keep(self, rows: NDArray[np.bool_]) -> Looks:
        """A selection of the looks."""
        return Looks(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})


@dataclass(frozen=True)
class FalseBoxes:
    """Boxes that match no thing."""

    frames: int
    """Frames that were looked at."""
    score: NDArray[np.float64]
    """(m,) scores."""


class Witness(BoxDetector):
    """Wraps a detector without changing it, and records every look."""

    def __init__(self, detector: BoxDetector) -> None:
        """Wrap a detector.

        Args:
            detector: used unchanged, as is its tracker.
        """
        self._errors_file = None
        self.inner, self.name, self.needs_rgb = detector, detector.name, detector.needs_rgb
        self.rows: list[tuple[float, ...]] = []
        self.false: list[float] = []
        self.frames = self.home = 0
        self._row = {name: k for k, name in enumerate(vocabulary())}

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode."""
        self.inner.reset(episode, categories)
        self._categories = categories
        self._thing = np.array([name not in STRUCTURE_KINDS for name in categories], bool)

    def find(self, frame: Frame) -> Boxes:
        """Boxes of the detector; what they match is recorded."""
        boxes = self.inner.find(frame)
        self._note(frame, boxes)
        return boxes

    def detect(self, frame: Frame) -> Detections:
        """As the wrapped detector, which is asked once."""
        return self.inner.follow(self.find(frame), frame)

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """As the wrapped detector."""
        return self.inner.tracks_of(instances)

    def close(self) -> None:
        """As the wrapped detector."""
        self.inner.close()

    def _note(self, frame: Frame, boxes: Boxes) -> None:
        """Match boxes with things, and record every thing in view and every box on nothing."""
        n = len(frame.counts)
        box, middle, count = np.empty((n, 4), np.int32), np.empty((n, 3)), np.empty(n, np.int32)
        outline(frame.depth, frame.instance, frame.camera, box, middle, count)
        # Things too small to count as seen are recorded too: else far looks at small things would seem too good.
        seen = np.flatnonzero((frame.counts >= 1) & (count > 0) & self._thing)
        of = self._matched(boxes, seen, box[seen].astype(np.float32))
        away = middle[seen] - frame.camera[:3]
        away_m, bearing = np.linalg.norm(away, axis=1), np.arctan2(away[:, 1], away[:, 0])
        by_thing = {int(thing): k for k, thing in enumerate(of.tolist()) if thing >= 0}
        for k, thing in enumerate(seen.tolist()):
            name, b = self._categories[thing], by_thing.get(thing)
            whole = float(whole_pixels(name, away_m[k : k + 1])[0])
            called, score = (-1, 0.0) if b is None else (self._row[boxes.label[b]], float(boxes.score[b]))
            pixels, direction = float(frame.counts[thing]), float(bearing[k])
            self.rows.append(
                (
                    self.home,
                    thing,
                    self._row.get(name, -1),
                    pixels,
                    whole,
                    away_m[k],
                    direction,
                    b is not None,
                    called,
                    score,
                )
            )
        self.false += [float(s) for s, thing in zip(boxes.score, of.tolist(), strict=True) if thing < 0]
        self.frames += 1

    def _matched(self, boxes: Boxes, seen: NDArray[np.intp], outlines: NDArray[np.float32]) -> NDArray[np.int64]:
        """The thing of every box, (n,) int64, -1 for none: by largest overlap, where the right name adds a little."""
        of = np.full(len(boxes.label), -1)
        pairs = []
        for k, label in enumerate(boxes.label):
            shared = overlap(boxes.xyxy[k], outlines)
            for row in np.flatnonzero(shared >= LEAST_OVERLAP).tolist():
                named = self._categories[int(seen[row])] == label
                pairs.append((-float(shared[row]) - 0.3 * named, k, int(seen[row])))
        taken: set[int] = set()
        for _, k, thing in sorted(pairs):
            if of[k] < 0 and thing not in taken:
                of[k] = thing
                taken.add(thing)
        return of

    def looks(self) -> tuple[Looks, FalseBoxes]:
        """All looks at things so far, and all boxes on nothing."""
        columns = np.array(self.rows, np.float64).reshape(-1, 10).T
        types = (np.int32,) * 3 + (np.float64,) * 4 + (np.bool_, np.int32, np.float64)
        looks = Looks(*(column.astype(kind) for column, kind in zip(columns, types, strict=True)))
        return looks, FalseBoxes(self.frames, np.array(self.false))


def walk(episode: Episode, seed: int) -> Iterator[int]:
    """Actions along an episode's solution, with turns on the spot, looks up and down, and no Done."""
    draw = stream(seed, "detector looks", episode.id)
    for number, digit in enumerate(episode.solution):
        if int(digit) == Action.DONE:
            return
        yield int(digit)
        if number % _BETWEEN_TURNS == 0:
            look = int(draw.choice([Action.LOOK_UP, Action.LOOK_DOWN, Action.LOOK_DOWN]))
            yield look
            yield from [int(Action.ROTATE_LEFT)] * 4
            yield int(Action.LOOK_DOWN if look == Action.LOOK_UP else Action.LOOK_UP)


def collect(
    detector: BoxDetector, episodes: Sequence[Episode], seed: int = 0, tick: Callable[[int], object] = lambda done: None
) -> tuple[Looks, FalseBoxes]:
    """Walk through homes with a detector.

    Args:
        detector: the detector.
        episodes: one walk each.
        seed: of the looks up and down.
        tick: called with the number of walks done.

    Returns:
        All looks, and the boxes on nothing.
    """
    witness = Witness(detector)
    env = UcONEnv(episodes, habit_level="none", observe="symbolic", detector=witness)
    try:
        for number, episode in enumerate(episodes):
            witness.home = number
            env.reset(options={"episode": number})
            for action in walk(episode, seed):
                if any(env.step(action)[2:4]):
                    break
            tick(number + 1)
    finally:
        env.close()
    return witness.looks()
