"""Files of a model's weights on this machine, and a fingerprint that reads only a few megabytes of them.

A folder's name does not identify a model: its weights may be replaced, and a resumed run would mix two models. File
times do not either, since copying changes them.
"""

from __future__ import annotations

import hashlib
from math import prod
from pathlib import Path
from typing import Final

from ucon.core.errors import DataError
from ucon.core.files import sha256_bytes
from ucon.core.tensor_files import header

#: Files of a model in Hugging Face layout.
PATTERNS: Final = ("*.json", "*.safetensors", "*.bin", "*.txt", "*.model", "*.jinja")
#: Files that are downloaded: of the weights only safetensors, since the hub often has copies in older formats.
FETCHED: Final = tuple(pattern for pattern in PATTERNS if pattern != "*.bin")
_WEIGHTS: Final = (".safetensors", ".bin")
_WHOLE_BYTES: Final = 4 << 20
_MOST_HEADER: Final = 16 << 20
_PIECES, _PIECE_BYTES = 64, 16 << 10


def local_folder(name: str, *, download: bool = False) -> Path | None:
    """Folder of a model.

    Args:
        name: a path, or a name in the Hugging Face cache.
        download: fetch a name that is not in the cache from the hub.

    Returns:
        The folder; None if there is none.
    """
    folder = Path(name).expanduser()
    if folder.is_dir():
        return folder
    from huggingface_hub import snapshot_download

    try:
        return Path(snapshot_download(name, local_files_only=not download, allow_patterns=list(FETCHED)))
    except Exception:  # the hub's client raises many kinds: offline, no such name, a licence not accepted
        return None


def missing_parts(folder: Path) -> list[str]:
    """The parts that a model in Hugging Face layout needs and ``folder`` lacks."""
    missing = [] if (folder / "config.json").is_file() else ["config.json"]
    if not any(path.suffix in _WEIGHTS for path in folder.iterdir()):
        missing.append("weights (*.safetensors)")
    return missing


def parameters_in(folder: Path) -> int:
    """Lower bound on a model's number of weights, by the headers of its safetensors files; other files count 0.

    Args:
        folder: in Hugging Face layout.
    """
    return sum(map(_parameters, sorted(folder.glob("*.safetensors"))))


def _parameters(path: Path) -> int:
    with path.open("rb") as file:
        start = file.read(8)
        raw = start + file.read(min(int.from_bytes(start, "little"), _MOST_HEADER))
    try:
        return sum(prod(shape) for _, shape in header(raw, path).values())
    except DataError:  # loading the model reports what is wrong with it
        return 0


def fingerprint(path: Path) -> str:
    """SHA-256 of a weights file, or of a model's files in a folder, over names, sizes and samples of the content.

    Small files, such as a configuration or the index of the weights, are hashed whole. Of large ones, the header (if
    there is one) and evenly spaced pieces are hashed, which differ between two sets of weights of the same shape.
    """
    kinds = {pattern.removeprefix("*") for pattern in PATTERNS}
    files = [path] if path.is_file() else sorted(p for p in path.iterdir() if p.is_file() and p.suffix in kinds)
    return sha256_bytes("\n".join(f"{file.name} {file.stat().st_size} {_sampled(file)}" for file in files).encode())


def _sampled(path: Path) -> str:
    digest, size = hashlib.sha256(), path.stat().st_size
    with path.open("rb") as file:
        if size <= _WHOLE_BYTES:
            return hashlib.sha256(file.read()).hexdigest()
        if path.suffix == ".safetensors":
            digest.update(file.read(min(int.from_bytes(file.read(8), "little"), _WHOLE_BYTES)))
        for piece in range(_PIECES):
            file.seek(piece * (size - _PIECE_BYTES) // (_PIECES - 1))
            digest.update(file.read(_PIECE_BYTES))
    return digest.hexdigest()
