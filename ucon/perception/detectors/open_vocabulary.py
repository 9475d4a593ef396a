"""The common part of detectors that run open-vocabulary models of the transformers library.

Weights are read from a folder or from the Hugging Face cache; they are fetched only with ``download``. Detectors of one
process that name the same weights share one model.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ucon.core.errors import ConfigError, DetectorError, brief
from ucon.core.untrusted.weight_files import fingerprint, local_folder, missing_parts
from ucon.perception.detectors.base import Frame, vocabulary
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.tracking.tracker import GATE_M

if TYPE_CHECKING:
    import torch

_DTYPES = ("float32", "float16", "bfloat16")


@dataclass(frozen=True, slots=True)
class DetectorWeights:
    """Which model a detector runs, on which device and in which precision.

    Raises:
        ConfigError: at construction, for an unknown dtype.
    """

    from_command_line: ClassVar = ("download",)
    """A stored configuration may not switch downloads on; only the command line may."""
    model: str
    """A folder, or a name on the Hugging Face hub."""
    device: str = "cpu"
    """As torch names it."""
    dtype: str = "float32"
    """float32, float16 or bfloat16; the 16-bit types are meant for GPUs."""
    download: bool = False
    """Whether weights that are not in the cache are fetched."""

    def __post_init__(self) -> None:
        if self.dtype not in _DTYPES:
            raise ConfigError(f"detector dtype={self.dtype!r}: expected one of {', '.join(_DTYPES)}")


@dataclass(frozen=True, slots=True)
class Loaded:
    """A transformers model in evaluation mode and its processor."""

    model: Any
    processor: Any


@lru_cache(maxsize=2)
def load(weights: DetectorWeights) -> Loaded:
    """Load a model and its processor; the last two are kept.

    Args:
        weights: which model, device and dtype.

    Raises:
        DetectorError: the weights are not there, or are not a zero-shot object detection model.
    """
    import torch
    from transformers import AutoModelForZeroShotObjectDetection, AutoProcessor

    local = not weights.download
    try:
        processor = AutoProcessor.from_pretrained(weights.model, local_files_only=local, trust_remote_code=False)
        model = AutoModelForZeroShotObjectDetection.from_pretrained(
            weights.model, local_files_only=local, trust_remote_code=False, dtype=getattr(torch, weights.dtype)
        )
        model = model.to(weights.device).eval()
    except (OSError, ValueError, ImportError, RuntimeError) as error:
        raise DetectorError(
            f"detector weights {weights.model} on {weights.device} cannot be loaded ({brief(str(error))}); give the "
            "folder of a model, or set download=true once to fetch it into the cache"
        ) from None
    return Loaded(model, processor)


class OpenVocabularyDetector(BoxDetector):
    """A detector that finds the names of its vocabulary in the colour image.

    Weights are loaded at the first frame, so that an environment can be described without them.
    """

    def __init__(
        self,
        weights: DetectorWeights,
        *,
        threshold: float,
        nms_iou: float = 0.5,
        most_boxes: int = 100,
        names: Sequence[str] | None = None,
        gate_m: float = GATE_M,
        errors: str | None = None,
    ) -> None:
        """Set the options; nothing is loaded yet.

        Args:
            weights: which model, device and dtype.
            threshold: least score of a box, from 0 to below 1.
            nms_iou: of boxes of one name that overlap by more, the best stays.
            most_boxes: most boxes that are kept in one frame.
            names: the vocabulary, by default all names of the catalogue.
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with its errors; None: those that come with the package, where there are any.

        Raises:
            ConfigError: a number is out of its range.
        """
        super().__init__(gate_m, errors)
        if not 0.0 <= threshold < 1.0 or not 0.0 <= nms_iou <= 1.0 or most_boxes < 1:
            raise ConfigError(
                f"detector: threshold={threshold}, nms_iou={nms_iou}, most_boxes={most_boxes}: expected a threshold "
                "from 0 to below 1, an overlap from 0 to 1, and at least one box"
            )
        self._weights, self._threshold = weights, threshold
        self._nms_iou, self._most_boxes = nms_iou, most_boxes
        self._names = vocabulary() if names is None else tuple(names)

    def check(self) -> None:
        """Check that the weights' files are there; nothing is loaded.

        Raises:
            DetectorError: there is no such folder and no cached model of that name, or files are missing in it.
        """
        weights = self._weights
        folder = local_folder(weights.model, download=weights.download)
        missing = ["folder or cached model of that name"] if folder is None else missing_parts(folder)
        if missing:
            raise DetectorError(
                f"detector {self.name}: weights {weights.model}: no {', no '.join(missing)}; give the folder of a "
                "model, or set download=true once to fetch it into the cache"
            )

    def fingerprint(self) -> str | None:
        """Checksum of the weights on this machine; None where there are none."""
        folder = local_folder(self._weights.model)
        return None if folder is None else fingerprint(folder)

    def find(self, frame: Frame) -> Boxes:
        """Boxes of the vocabulary's names in one frame, after non-maximum suppression.

        Returns:
            Boxes in the frame's pixels, clipped to it, by falling score.

        Raises:
            DetectorError: the frame has no colour image, or the weights cannot be loaded.
        """
        import torch

        if frame.rgb is None:
            raise DetectorError(f"detector {self.name}: the frame has no colours; render rgb for it")
        with torch.inference_mode():
            found = self._raw(load(self._weights), frame.rgb)
        height, width = frame.depth.shape
        xyxy = np.clip(found.xyxy, 0, np.array([width, height, width, height], np.float32))
        inside = np.flatnonzero(((xyxy[:, 2:] - xyxy[:, :2]) > 0.5).all(1))
        return (
            Boxes(found.label, found.score, xyxy).keep(inside).non_maximum_suppression(self._nms_iou, self._most_boxes)
        )

    @abstractmethod
    def _raw(self, loaded: Loaded, rgb: np.ndarray) -> Boxes:
        """All boxes above the threshold in an image (H, W, 3) uint8, in its pixels."""

    def _result(self, label: Sequence[str], score: torch.Tensor, xyxy: torch.Tensor) -> Boxes:
        """Boxes from a model's tensors: ``score`` (n,), ``xyxy`` (n, 4) pixels."""
        numbers = [np.asarray(t.float().cpu().numpy(), np.float32) for t in (score, xyxy)]
        return Boxes(list(label), numbers[0], numbers[1].reshape(-1, 4))
