"""The boxes that a detector finds in one image, before they are tracked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DetectorError, brief


@dataclass(frozen=True, slots=True)
class Boxes:
    """n labelled, scored boxes in one frame."""

    label: Sequence[str]
    """n catalogue names."""
    score: NDArray[np.float32]
    """(n,) confidence from 0 to 1."""
    xyxy: NDArray[np.float32]
    """(n, 4) left, top, right, bottom in pixels; right and bottom are exclusive."""
    mask: NDArray[np.bool_] | None = None
    """(n, H, W) pixels of each box's thing; None from detectors that do not segment."""

    def check(self, detector: str) -> None:
        """Check that scores and edges are what a detector may report.

        Args:
            detector: its name, for the error.

        Raises:
            DetectorError: scores outside [0, 1], or edges that are no numbers.
        """
        odd = np.flatnonzero(~((self.score >= 0.0) & (self.score <= 1.0)))
        if len(odd):
            k = int(odd[0])
            raise DetectorError(
                f"detector {detector}: score {self.score[k]} of a {brief(self.label[k])}; expected a number from 0 to 1"
            )
        if not np.isfinite(self.xyxy).all():
            k = int(np.flatnonzero(~np.isfinite(self.xyxy).all(1))[0])
            raise DetectorError(
                f"detector {detector}: the box of a {brief(self.label[k])} has edges that are not numbers"
            )

    @classmethod
    def none(cls) -> Boxes:
        """No boxes: n is 0."""
        return cls((), np.zeros(0, np.float32), np.zeros((0, 4), np.float32))

    def keep(self, rows: Sequence[int] | NDArray[np.intp]) -> Boxes:
        """A selection of the boxes.

        Args:
            rows: row numbers; the result has them in this order.
        """
        chosen = np.asarray(rows, np.intp)
        mask = None if self.mask is None else self.mask[chosen]
        return Boxes([self.label[k] for k in chosen], self.score[chosen], self.xyxy[chosen], mask)

    def non_maximum_suppression(self, iou: float, most: int) -> Boxes:
        """Non-maximum suppression within each label.

        Args:
            iou: of boxes of one label that overlap by more than this, the one with the highest score stays.
            most: most boxes that are kept.

        Returns:
            The kept boxes, by falling score.
        """
        order = np.argsort(-self.score, kind="stable")
        label = np.array(self.label)
        kept: list[int] = []
        for k in order.tolist():
            same = [j for j in kept if label[j] == label[k]]
            if len(kept) < most and (not same or overlap(self.xyxy[k], self.xyxy[same]).max() <= iou):
                kept.append(k)
        return self.keep(kept)


def overlap(box: NDArray[np.float32], others: NDArray[np.float32]) -> NDArray[np.float32]:
    """Intersection over union of one box with others.

    Args:
        box: (4,) left, top, right, bottom.
        others: (n, 4).

    Returns:
        (n,) float32 in [0, 1].
    """
    low, high = np.maximum(box[:2], others[:, :2]), np.minimum(box[2:], others[:, 2:])
    shared = np.prod(np.maximum(high - low, 0.0), axis=1)
    area = np.prod(np.maximum(box[2:] - box[:2], 0.0))
    areas = np.prod(np.maximum(others[:, 2:] - others[:, :2], 0.0), axis=1)
    result: NDArray[np.float32] = shared / np.maximum(area + areas - shared, 1e-9)
    return result
