"""Grounding DINO: finds the phrases of a text prompt in an image.

Its text window holds about sixty names, so the vocabulary takes a dozen prompts. Each prompt is a pass through the
whole model, because text and image features are fused; only the tokens are kept between frames. The model reports spans
of the prompt, which are mapped back to catalogue names.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.open_vocabulary import DetectorWeights, Loaded, OpenVocabularyDetector
from ucon.perception.detectors.phrases import Names, chunks, plain
from ucon.perception.tracking.tracker import GATE_M


class GroundingDinoDetector(OpenVocabularyDetector):
    """Boxes by Grounding DINO."""

    name = "grounding_dino"

    def __init__(
        self,
        weights: DetectorWeights,
        *,
        threshold: float = 0.35,
        text_threshold: float = 0.25,
        nms_iou: float = 0.5,
        most_boxes: int = 100,
        names: Sequence[str] | None = None,
        gate_m: float = GATE_M,
        errors: str | None = None,
    ) -> None:
        """Set the model's options; nothing is loaded yet.

        Args:
            weights: which model, device and dtype.
            threshold: least score of a box.
            text_threshold: least score of a token that belongs to a box's phrase.
            nms_iou: of boxes of one name that overlap by more, the best stays.
            most_boxes: most boxes that are kept in one frame.
            names: the vocabulary, by default all names of the catalogue.
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with its errors; None: those that come with the package, where there are any.

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
        self._text_threshold = text_threshold
        self._meant = Names(self._names)
        self._prompts: list[str] | None = None

    @property
    def unmatched(self) -> int:
        """How many phrases so far were not a name of the vocabulary, such as half of one; their boxes were dropped."""
        return self._meant.unmatched

    def prompts(self, loaded: Loaded) -> list[str]:
        """The vocabulary as prompts that fit the model's text window; computed once.

        Args:
            loaded: the model, for its tokenizer and window.

        Returns:
            Texts of the form "first name. second name."
        """
        if self._prompts is None:
            tokenizer = loaded.processor.tokenizer
            # Two tokens mark the beginning and the end.
            window = int(loaded.model.config.max_text_len) - 2
            parts = chunks(self._names, lambda text: len(tokenizer.tokenize(text)), window)
            self._prompts = [" ".join(f"{plain(name)}." for name in part) for part in parts]
        return self._prompts

    def _raw(self, loaded: Loaded, rgb: np.ndarray) -> Boxes:
        """Boxes of all prompts, in pixels of ``rgb`` (H, W, 3) uint8."""
        import torch

        labels: list[str] = []
        scores, boxes = [], []
        dtype, device = loaded.model.dtype, loaded.model.device
        for prompt in self.prompts(loaded):
            inputs = loaded.processor(images=rgb, text=prompt, return_tensors="pt").to(device)
            inputs["pixel_values"] = inputs["pixel_values"].to(dtype)
            found = loaded.processor.post_process_grounded_object_detection(
                loaded.model(**inputs),
                inputs["input_ids"],
                threshold=self._threshold,
                text_threshold=self._text_threshold,
                target_sizes=[rgb.shape[:2]],
            )[0]
            meant = [self._meant.of(phrase) for phrase in found["text_labels"]]
            rows = [k for k, name in enumerate(meant) if name is not None]
            labels.extend(name for name in meant if name is not None)
            scores.append(found["scores"][rows])
            boxes.append(found["boxes"][rows])
        return self._result(labels, torch.cat(scores), torch.cat(boxes))
