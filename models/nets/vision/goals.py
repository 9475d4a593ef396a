"""ZSON's goal as a vector: by CLIP's text encoder where its weights are given, else by the sentence encoder."""

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
    """Embeds the target's name with the shipped sentence encoder, 384 numbers.

    ZSON uses CLIP. These vectors are not aligned with images, so a policy trained on them knows words, not appearances.
    """

    @property
    def name(self) -> str:
        """Name of the sentence encoder."""
        return default_encoder().name

    @property
    def dim(self) -> int:
        """Size of a vector, 384."""
        return default_encoder().dim

    def check(self) -> None:
        """Nothing to check: the encoder is part of the package."""

    def fingerprint(self) -> str | None:
        """Empty: the encoder is part of the package."""
        return ""

    def encode(self, category: str) -> NDArray[np.float32]:
        """Unit vector (384,) of a category's name."""
        return np.asarray(default_encoder().encode([phrase(category)])[0], np.float32)

    def encode_image(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Not possible with a sentence encoder.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            "the sentence encoder reads no images, but the goal is one; give CLIP: "
            "part=clip_goal agent.policy.goal.path=FOLDER"
        )


class ClipGoal(ClipTower):
    """Embeds the target's name with CLIP's text encoder, as a unit vector.

    ZSON uses CLIP's ResNet-50, whose vectors have 1024 numbers: a folder with its text encoder, in the layout of
    transformers' ``CLIPTextModelWithProjection``, gives the paper's sizes. Other CLIPs have other sizes.
    """

    def __init__(self, path: str) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: folder in Hugging Face layout, or a name in its cache.
        """
        super().__init__(path, "CLIPTextModelWithProjection", _OPTION)
        self._known: dict[str, NDArray[np.float32]] = {}

    def encode(self, category: str) -> NDArray[np.float32]:
        """Unit vector (dim,) of a category's name; cached."""
        text = phrase(category)
        if text not in self._known:
            self._known[text] = self._encode(text)
        return self._known[text]

    def encode_image(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Unit vector (dim,) of an image (H, W, 3) uint8, in the same space as the names.

        The image encoder is read from the same folder.
        """
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
