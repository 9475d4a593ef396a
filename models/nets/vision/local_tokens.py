"""VTN's local tokens: a hundred things of a frame, each with label, box, score and a feature of 256 numbers.

Here the feature is learned, one for each category of the catalogue; :mod:`models.nets.vision.detr_tokens` takes it from
DETR.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import find_objects
from torch import Tensor, nn

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_bytes
from ucon.learning.policies.action_policy import Arrays, Tensors
from ucon.perception.detectors.base import vocabulary
from ucon.perception.mapping.detections import Detections

TOKENS: Final = 100
WIDTH: Final = 256


@lru_cache(maxsize=1)
def labels() -> dict[str, int]:
    """Numbers of the catalogue's things, from 1; pieces of the building are no things."""
    return {name: number for number, name in enumerate(vocabulary(), 1)}


class LabelTokens(nn.Module):
    """Tokens from what the environment's detector says (``detector=gt`` by default); features are learned.

    As in VTNet's preparation of DETR's output, the best of each label is kept, in the order of the labels; the largest
    where scores are equal. Rows without a thing are zero.
    """

    def __init__(self) -> None:
        super().__init__()
        self.embed = nn.Embedding(len(labels()) + 1, WIDTH, padding_idx=0)

    @property
    def name(self) -> str:
        """What the weights belong to: the labels and their numbers."""
        return f"labels {sha256_bytes(' '.join(labels()).encode())[:12]}"

    @property
    def n_labels(self) -> int:
        """The largest label."""
        return len(labels())

    def check(self) -> None:
        """Nothing is needed."""

    def fingerprint(self) -> str | None:
        """No weights of others."""
        return ""

    def label_of(self, category: str) -> int:
        """Number of a category; 0, which no token has, for what is no thing of the catalogue."""
        return labels().get(category, 0)

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Arrays ``label`` (100,) int16, ``score`` (100,) and ``box`` (100, 4) float16: x, y, x, y in 0..1.

        Raises:
            ConfigError: the environment has no detector.
        """
        if "detections" not in info:
            raise ConfigError("agent vtn: the environment has no detector; give detector=gt")
        found = Detections.from_info(info)
        best = _best_of_each(found)
        label, score = np.zeros(TOKENS, np.int16), np.zeros(TOKENS, np.float16)
        box = np.zeros((TOKENS, 4), np.float16)
        boxes = _boxes(found)
        for row, k in enumerate(best):
            label[row] = labels()[found.category[k]]
            score[row] = 1.0 if found.score is None else found.score[k]
            box[row] = boxes[int(found.track[k])]
        return {"label": label, "score": score, "box": box}

    def features(self, frames: Tensors) -> Tensors:
        """Nothing is frozen."""
        return frames

    def forward(self, frames: Tensors) -> Tensor:
        """Features (N, 100, 256) of ``label`` (N, 100)."""
        features: Tensor = self.embed(frames["label"].long())
        return features


def _best_of_each(found: Detections) -> list[int]:
    """Rows of detections, one for each label in view: the most certain, then the largest; at most a hundred."""
    known, in_view = labels(), set(np.unique(found.image).tolist())
    score = np.ones(len(found.track)) if found.score is None else np.asarray(found.score)
    best: dict[int, int] = {}
    for k in np.lexsort((found.track, -found.pixels, -score)).tolist():
        label = known.get(found.category[k])
        if label is not None and int(found.track[k]) in in_view and len(best) < TOKENS:
            best.setdefault(label, k)
    return [best[label] for label in sorted(best)]


def _boxes(found: Detections) -> dict[int, NDArray[np.float64]]:
    """Boxes of the tracks in the image, in parts of its sides."""
    height, width = found.image.shape
    size = np.array([width, height, width, height], np.float64)
    return {
        track: np.array([where[1].start, where[0].start, where[1].stop, where[0].stop]) / size
        for track, where in enumerate(find_objects(found.image.astype(np.int32) + 1))
        if where is not None
    }


def indicator(frames: Tensors, target: Tensor) -> Tensor:
    """VTN's only word of its target (N, 100): 1 for tokens of the label ``target`` (N,), 0 for others and none."""
    label = frames["label"].long()
    return ((label == target[:, None].long()) & (label > 0)).to(torch.float32)
