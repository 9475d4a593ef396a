"""VTN's local tokens: up to 100 things of a frame, each with label, box, score and a feature of 256 numbers.

Here the feature is a learned embedding of the category; :mod:`models.nets.vision.detr_tokens` takes it from DETR.
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
    """Label of each category of things in the catalogue, from 1; parts of the building have none."""
    return {name: number for number, name in enumerate(vocabulary(), 1)}


class LabelTokens(nn.Module):
    """Tokens from the environment's detector (``detector=gt`` by default); the features are learned.

    As in VTNet's preparation of DETR's output, the best detection of each label is kept, in the order of the labels;
    among equal scores the largest. Unused rows are zero.
    """

    def __init__(self) -> None:
        super().__init__()
        self.embed = nn.Embedding(len(labels()) + 1, WIDTH, padding_idx=0)

    @property
    def name(self) -> str:
        """``labels`` and a hash of all labels; trained weights depend on them."""
        return f"labels {sha256_bytes(' '.join(labels()).encode())[:12]}"

    @property
    def n_labels(self) -> int:
        """Number of labels."""
        return len(labels())

    def check(self) -> None:
        """Nothing to check: no frozen weights."""

    def fingerprint(self) -> str | None:
        """Empty: no frozen weights."""
        return ""

    def label_of(self, category: str) -> int:
        """Label of a category; 0, which no token has, outside the catalogue."""
        return labels().get(category, 0)

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Arrays ``label`` (100,) int16, ``score`` (100,) float16 and ``box`` (100, 4) float16: x, y, x, y in 0..1.

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
        """The frames unchanged: no network is frozen."""
        return frames

    def forward(self, frames: Tensors) -> Tensor:
        """Features (N, 100, 256) of ``label`` (N, 100)."""
        features: Tensor = self.embed(frames["label"].long())
        return features


def _best_of_each(found: Detections) -> list[int]:
    """Rows of detections, the best of each label in view: highest score, then most pixels; at most 100."""
    known, in_view = labels(), set(np.unique(found.image).tolist())
    score = np.ones(len(found.track)) if found.score is None else np.asarray(found.score)
    best: dict[int, int] = {}
    for k in np.lexsort((found.track, -found.pixels, -score)).tolist():
        label = known.get(found.category[k])
        if label is not None and int(found.track[k]) in in_view and len(best) < TOKENS:
            best.setdefault(label, k)
    return [best[label] for label in sorted(best)]


def _boxes(found: Detections) -> dict[int, NDArray[np.float64]]:
    """Box of each track in the image, as shares of its sides."""
    height, width = found.image.shape
    size = np.array([width, height, width, height], np.float64)
    return {
        track: np.array([where[1].start, where[0].start, where[1].stop, where[0].stop]) / size
        for track, where in enumerate(find_objects(found.image.astype(np.int32) + 1))
        if where is not None
    }


def indicator(frames: Tensors, target: Tensor) -> Tensor:
    """Marks the target's tokens, VTN's only input about its goal.

    Args:
        frames: with ``label`` (N, 100).
        target: (N,) label that is looked for.

    Returns:
        (N, 100) float32: 1 for tokens with the target's label, else 0.
    """
    label = frames["label"].long()
    return ((label == target[:, None].long()) & (label > 0)).to(torch.float32)
