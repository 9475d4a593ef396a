"""VTN's local tokens as in the paper: features, labels and boxes of DETR's 100 queries (Carion et al., 2020)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, Final

import torch
from torch import Tensor, nn

from models.nets.vision.frozen import FrozenWeights, without_models
from models.nets.vision.local_tokens import TOKENS, WIDTH
from ucon.core.errors import ConfigError, DataError
from ucon.learning.policies.action_policy import Arrays, Tensors
from ucon.perception.detectors.phrases import Names, plain

_CHUNK: Final = 16
_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
_OPTION: Final = "agent.policy.tokens.path"


class DetrTokens(nn.Module):
    """Tokens from a frozen DETR that reads the colour image; none of its weights are trained.

    For each label the query with the highest score is kept, in the order of the labels; queries for "nothing" are left
    out. VTNet fine-tuned DETR on its own scenes. Here any DETR in the folder is used, such as the published one of COCO
    (``hf download facebook/detr-resnet-50 --revision no_timm``), whose 91 labels cover few targets. A target's label is
    the longest one that its name contains as words ("coffee cup" is a cup); a target without one is never marked.
    """

    def __init__(self, path: str, image_px: int = 800) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: folder in Hugging Face layout, or a name in its cache.
            image_px: side of the image that DETR reads.

        Raises:
            ConfigError: ``image_px`` below 32.
        """
        super().__init__()
        if image_px < 32:
            raise ConfigError(f"agent.policy.tokens.image_px={image_px}: expected 32 or more")
        self._weights = FrozenWeights(path, "DetrForObjectDetection", _OPTION)
        self._image_px = image_px

    @property
    def name(self) -> str:
        """``detr``, a hash of the files and the image's side; trained weights depend on them."""
        return f"detr {self._weights.identity} {self._image_px}"

    @cached_property
    def n_labels(self) -> int:
        """Number of labels; COCO counts from 1, and 0 means none here."""
        return int(self._model.config.num_labels)

    @cached_property
    def _labels(self) -> dict[str, int]:
        return {plain(str(name)): int(k) + 1 for k, name in self._model.config.id2label.items()}

    def check(self) -> None:
        """Raise :class:`DataError` where the files are missing; loads nothing."""
        self._weights.check()

    def fingerprint(self) -> str | None:
        """Hash of the files; None where they are missing."""
        return self._weights.fingerprint()

    def label_of(self, category: str) -> int:
        """The longest label that a category's name contains; 0, which no token has, where there is none."""
        found = Names(tuple(self._labels)).of(category)
        return 0 if found is None else self._labels[found]

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Empty: ``rgb``, which the policy adds, is all that is needed."""
        return {}

    @torch.no_grad()
    def features(self, frames: Tensors) -> Tensors:
        """Tokens of ``rgb`` (..., H, W, 3): ``feature`` (..., 100, 256) float16, and ``label``, ``score`` and ``box``.

        The last three are as in :class:`models.nets.vision.local_tokens.LabelTokens`.
        """
        rgb = frames["rgb"]
        lead = rgb.shape[:-3]
        with torch.autocast(rgb.device.type, enabled=False):
            parts = [self._found(part) for part in rgb.reshape(-1, *rgb.shape[-3:]).split(_CHUNK)]
            return self._together(parts, lead)

    @staticmethod
    def _together(parts: list[dict[str, Tensor]], lead: torch.Size) -> dict[str, Tensor]:
        return {name: torch.cat([part[name] for part in parts]).unflatten(0, lead) for name in parts[0]}

    def forward(self, frames: Tensors) -> Tensor:
        """Features (N, 100, 256) float32."""
        return frames["feature"].float()

    def _found(self, rgb: Tensor) -> dict[str, Tensor]:
        images = rgb.permute(0, 3, 1, 2).float() / 255
        size = (self._image_px, self._image_px)
        images = torch.nn.functional.interpolate(images, size, mode="bilinear", align_corners=False)
        mean, deviation = (images.new_tensor(values).view(3, 1, 1) for values in (_MEAN, _DEVIATION))
        found = self._model.to(rgb.device)(pixel_values=(images - mean) / deviation)
        score, label = found.logits.softmax(-1).max(-1)  # (n, 100); the last label is "nothing"
        keep = _best_rows(label, score, self.n_labels)
        order = torch.where(keep, label, self.n_labels).argsort(
            dim=1, stable=True
        )  # sorted by label, dropped queries last
        keep = keep.gather(1, order)
        middle, size_wh = found.pred_boxes.split(2, -1)
        box = torch.cat([middle - size_wh / 2, middle + size_wh / 2], -1)
        return {
            "label": ((label.gather(1, order) + 1) * keep).short(),
            "score": (score.gather(1, order) * keep).half(),
            "box": _rows(box, order, keep),
            "feature": _rows(found.last_hidden_state, order, keep),
        }

    def __getstate__(self) -> dict[str, Any]:
        return without_models(self, "_model")

    @cached_property
    def _model(self) -> Any:
        model = self._weights.model
        shape = (int(model.config.num_queries), int(model.config.d_model))
        if shape != (TOKENS, WIDTH):
            expected = f"expected {TOKENS} and {WIDTH}"
            raise DataError(f"{_OPTION}={self._weights.path}: {shape[0]} queries of width {shape[1]}, {expected}")
        return model


def _best_rows(label: Tensor, score: Tensor, nothing: int) -> Tensor:
    """Which queries have the highest score of their label, (n, 100) bool; the first among equals.

    Queries for ``nothing`` never count.
    """
    same = label[:, :, None] == label[:, None, :]  # (n, 100, 100)
    place = torch.arange(label.shape[1], device=label.device)
    earlier = place[None, :] < place[:, None]
    beaten = (score[:, None, :] > score[:, :, None]) | ((score[:, None, :] == score[:, :, None]) & earlier)
    return (label < nothing) & ~(same & beaten).any(-1)


def _rows(values: Tensor, order: Tensor, keep: Tensor) -> Tensor:
    """Rows of ``values`` (n, 100, w) in ``order`` (n, 100), zero where not kept, as float16."""
    sorted_rows = values.gather(1, order[..., None].expand_as(values))
    return (sorted_rows * keep[..., None]).half()
