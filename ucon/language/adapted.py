"""MiniLM with a trained adapter. It has its own name, so that its vectors never mix with the frozen encoder's."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from ucon.core.files import read_verified, sha256_bytes
from ucon.language.encoder import MINILM_SHA256, MiniLM, Progress


class AdaptedMiniLM(MiniLM):
    """all-MiniLM-L6-v2 with an adapter (:mod:`ucon.language.adapter`) added to its matrices."""

    def __init__(
        self, adapter: Path, folder: Path | None = None, *, check: bool = True, progress: Progress | None = None
    ) -> None:
        """Choose adapter and weights; nothing is read yet.

        Args:
            adapter: a safetensors file next to its manifest.
            folder: of the weights; see :class:`MiniLM`.
            check: verify the SHA-256 of the weights.
            progress: called with (texts done, texts in all).
        """
        super().__init__(folder, check=check, progress=progress)
        self._adapter = adapter

    @cached_property
    def name(self) -> str:  # type: ignore[override]
        """Name of the frozen encoder with the start of the adapter's hash."""
        return f"{super().name}+{sha256_bytes(read_verified(self._adapter))[:8]}"

    def _load(self) -> None:
        if self._model is not None:
            return
        from ucon.language.adapter import merge, read_adapter

        adapter = read_adapter(self._adapter, MINILM_SHA256)
        super()._load()
        merge(self._model, adapter, str(self._adapter))  # type: ignore[arg-type]
