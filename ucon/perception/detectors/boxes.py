"""What a detector finds in one picture, before it is followed: labelled, scored pixel boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Boxes:
    """n boxes in one frame."""

    label: Sequence[str]
    """n catalogue names."""
    score: NDArray[np.float32]
    """(n,) from 0 to 1."""
    xyxy: NDArray[np.float32]
    """(n, 4) pixels: left, top, right, bottom; the last two lie just outside."""
    mask: NDArray[np.bool_] | None = None
    """(n, H, W) pixels of each, from detectors that segment."""

    @classmethod
    def none(cls) -> Boxes:
        """No box at all."""
        return cls((), np.zeros(0, np.float32), np.zeros((0, 4), np.float32))

    def keep(self, rows: Sequence[int] | NDArray[np.intp]) -> Boxes:
        """Only these rows, in this order."""
        chosen = np.asarray(rows, np.intp)
        mask = None if self.mask is None else self.mask[chosen]
        return Boxes([self.label[k] for k in chosen], self.score[chosen], self.xyxy[chosen], mask)

    def without_doubles(self, iou: float, most: int) -> Boxes:
        """Best first: of boxes of one label that overlap by more than ``iou`` the best stays; ``most`` in all."""
        order = np.argsort(-self.score, kind="stable")
        label = np.array(self.label)
        kept: list[int] = []
        for k in order.tolist():
            same = [j for j in kept if label[j] == label[k]]
            if len(kept) < most and (not same or overlap(self.xyxy[k], self.xyxy[same]).max() <= iou):
                kept.append(k)
        return self.keep(kept)


def overlap(box: NDArray[np.float32], others: NDArray[np.float32]) -> NDArray[np.float32]:
    """Intersection over union of one box (4,) with others (n, 4)."""
    low, high = np.maximum(box[:2], others[:, :2]), np.minimum(box[2:], others[:, 2:])
    shared = np.prod(np.maximum(high - low, 0.0), axis=1)
    area = np.prod(np.maximum(box[2:] - box[:2], 0.0))
    areas = np.prod(np.maximum(others[:, 2:] - others[:, :2], 0.0), axis=1)
    result: NDArray[np.float32] = shared / np.maximum(area + areas - shared, 1e-9)
    return result
