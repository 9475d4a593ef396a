"""OWLv2: compares every patch of an image with every name. Names are embedded once, whatever their number."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.open_vocabulary import DetectorWeights, Loaded, OpenVocabularyDetector
from ucon.perception.detectors.phrases import plain
from ucon.perception.tracking.tracker import GATE_M

if TYPE_CHECKING:
    import torch

#: The prompt that the model's authors evaluated with.
TEMPLATE = "a photo of a {}"


class Owlv2Detector(OpenVocabularyDetector):
    """Boxes by OWLv2."""

    name = "owlv2"

    def __init__(
        self,
        weights: DetectorWeights,
        *,
        threshold: float = 0.2,
        nms_iou: float = 0.5,
        most_boxes: int = 100,
        names: Sequence[str] | None = None,
        gate_m: float = GATE_M,
        errors: str | None = None,
        batch: int = 64,
    ) -> None:
        """Set the model's options; nothing is loaded yet.

        Args:
            weights: which model, device and dtype.
            threshold: least score of a box.
            nms_iou: of boxes of one name that overlap by more, the best stays.
            most_boxes: most boxes that are kept in one frame.
            names: the vocabulary, by default all names of the catalogue.
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with its errors; None: those that come with the package, where there are any.
            batch: number of names that are embedded at a time.

        Raises:
            ConfigError: a number is out of its range.
        """
        super().__init__(
            weights,
            threshold=threshold,
            nms_iou=nms_iou,
            most_boxes=most_boxes,
            names=names,
            gate_m=gate_m,
            errors=errors,
        )
        self._batch = batch
        self._queries: torch.Tensor | None = None

    def queries(self, loaded: Loaded) -> torch.Tensor:
        """Text embeddings of the n names, computed once.

        Args:
            loaded: the model.

        Returns:
            (n, D) tensor on the model's device, rows of length 1.
        """
        import torch

        if self._queries is None:
            parts = []
            for first in range(0, len(self._names), self._batch):
                texts = [TEMPLATE.format(plain(name)) for name in self._names[first : first + self._batch]]
                inputs = loaded.processor(text=[texts], return_tensors="pt").to(loaded.model.device)
                features = loaded.model.owlv2.get_text_features(inputs["input_ids"], inputs["attention_mask"])
                parts.append(features.pooler_output)
            embedded = torch.cat(parts)
            self._queries = embedded / torch.linalg.norm(embedded, dim=-1, keepdim=True)
        return self._queries

    def _raw(self, loaded: Loaded, rgb: np.ndarray) -> Boxes:
        """Boxes of all names, in pixels of ``rgb`` (H, W, 3) uint8."""
        model, processor = loaded.model, loaded.processor
        queries = self.queries(loaded)
        pixels = processor(images=rgb, return_tensors="pt")["pixel_values"].to(model.device, model.dtype)
        features = model.image_embedder(pixel_values=pixels)[0]
        patches = features.reshape(1, -1, features.shape[-1])
        logits = model.class_predictor(patches, queries[None])[0]
        outputs = SimpleNamespace(logits=logits, pred_boxes=model.box_predictor(patches, features))
        found = processor.post_process_grounded_object_detection(
            outputs, threshold=self._threshold, target_sizes=[rgb.shape[:2]], text_labels=[list(self._names)]
        )[0]
        return self._result(found["text_labels"], found["scores"], found["boxes"])
