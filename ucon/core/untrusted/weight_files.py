"""Files of a model's weights on this machine: where they are, and a fingerprint of them that reads a few megabytes.

The name of a folder says little: weights may be exchanged under it, and a run that goes on would mix two models. Times
of files say nothing either, since copies have others.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Final

from ucon.core.files import sha256_bytes

#: What a model in Hugging Face layout is made of.
PATTERNS: Final = ("*.json", "*.safetensors", "*.bin", "*.txt", "*.model", "*.jinja")
#: What is fetched: weights are on the hub as safetensors, often as copies in older formats besides.
FETCHED: Final = tuple(pattern for pattern in PATTERNS if pattern != "*.bin")
_WEIGHTS: Final = (".safetensors", ".bin")
_WHOLE_BYTES: Final = 4 << 20
_PIECES, _PIECE_BYTES = 64, 16 << 10


def local_folder(name: str, *, download: bool = False) -> Path | None:
    """Folder of a model by path or by its name in the Hugging Face cache; None where there is none.

    ``download`` gets a name from the hub that is not in the cache.
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
    """What a model in Hugging Face layout needs and ``folder`` lacks."""
    missing = [] if (folder / "config.json").is_file() else ["config.json"]
    if not any(path.suffix in _WEIGHTS for path in folder.iterdir()):
        missing.append("weights (*.safetensors)")
    return missing


def fingerprint(path: Path) -> str:
    """SHA-256 of a weights file, or of a model's files in a folder: names, sizes and samples of what is in them.

    Small files count whole, such as a configuration or the index of the weights; of large ones the header (where there
    is one) and pieces spread evenly, which two sets of weights of one shape do not share.
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
