"""What ZSON is looking for, as a vector: CLIP's text tower where its weights lie here, the shipped encoder else."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray

from models.nets.vision.clip_eye import ClipEye
from models.nets.vision.frozen import ClipTower, without_models
from ucon.core.errors import ConfigError, DataError
from ucon.core.untrusted.weight_files import local_folder
from ucon.language.encoder import quiet
from ucon.language.phrases import phrase
from ucon.language.store import default_encoder

_OPTION: Final = "agent.policy.goal.path"


class SentenceGoal:
    """The name of the target by the sentence encoder that is installed with the package: 384 numbers.

    Not ZSON's: nothing ties these vectors to images, so a policy trained on them knows words, not looks.
    """

    @property
    def name(self) -> str:
        """Name of the encoder."""
        return default_encoder().name

    @property
    def dim(self) -> int:
        """384."""
        return default_encoder().dim

    def check(self) -> None:
        """Nothing is needed."""

    def fingerprint(self) -> str | None:
        """The encoder is part of the package."""
        return ""

    def encode(self, category: str) -> NDArray[np.float32]:
        """Unit vector (384,) of a category's name."""
        return np.asarray(default_encoder().encode([phrase(category)])[0], np.float32)

    def encode_image(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """It has none.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            "the sentence encoder knows no images, and the goal is one; give CLIP: "
            "part=clip_goal agent.policy.goal.path=FOLDER"
        )


class ClipGoal(ClipTower):
    """The bare name of the target by CLIP's text tower, of length 1.

    ZSON takes CLIP's ResNet-50, whose vectors have 1024 numbers: a folder with its text tower, in the layout of
    transformers' ``CLIPTextModelWithProjection``, gives the paper's sizes. With other CLIPs the width is theirs.
    """

    def __init__(self, path: str) -> None:
        """``path``: folder in Hugging Face layout or a name in its cache."""
        super().__init__(path, "CLIPTextModelWithProjection", _OPTION)
        self._known: dict[str, NDArray[np.float32]] = {}

    def encode(self, category: str) -> NDArray[np.float32]:
        """Unit vector (dim,) of a category's name."""
        text = phrase(category)
        if text not in self._known:
            self._known[text] = self._encode(text)
        return self._known[text]

    def encode_image(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Unit vector (dim,) of an image (H, W, 3) by the other tower of the same folder: the same space."""
        return np.asarray(self._eye.vectors(torch.from_numpy(rgb)[None])[0].float().numpy(), np.float32)

    @cached_property
    def _eye(self) -> ClipEye:
        return ClipEye(self._weights.path, _OPTION)

    def __getstate__(self) -> dict[str, Any]:
        return without_models(self, "_tokenizer", "_eye")

    @torch.no_grad()
    def _encode(self, text: str) -> NDArray[np.float32]:
        inputs = self._tokenizer(text, return_tensors="pt", truncation=True)
        found = self._weights.model(**inputs).text_embeds[0].float()
        return np.asarray((found / found.norm()).numpy(), np.float32)

    @cached_property
    def _tokenizer(self) -> Any:
        self._weights.check()
        import transformers

        try:
            with quiet(transformers):
                folder = local_folder(self._weights.path)
                return transformers.AutoTokenizer.from_pretrained(
                    folder, local_files_only=True, trust_remote_code=False
                )
        except Exception as error:  # a damaged file fails in many ways
            line = " ".join(str(error).split())[:120]
            raise DataError(f"{_OPTION}={self._weights.path}: no tokenizer ({line}); get the whole model") from None
