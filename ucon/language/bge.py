"""BGE-M3, the retriever of the paper: dense vectors and lexical weights of texts, in one pass.

The weights (2.3 GB) are not shipped. They are read from a folder, or from the Hugging Face cache if ``BAAI/bge-m3`` is
in it; nothing is ever downloaded. As with every encoder here, texts go through the network one at a time on one thread
and the result is rounded to fp16, so a text's bytes do not depend on the other texts.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, remembered_sha256, sha256_bytes
from ucon.core.untrusted.strict_json import read_json
from ucon.language.encoder import Progress, Vectors, one_thread, quiet
from ucon.language.sparse import SparseRows

HUB_NAME: Final = "BAAI/bge-m3"
SPARSE_HEAD: Final = "sparse_linear.pt"
#: Names of the weights' file; the first one found is loaded. The model's authors publish the second.
WEIGHTS: Final = ("model.safetensors", "pytorch_model.bin")
_NEEDED = ("config.json", "modules.json", "tokenizer.json")
#: Files that decide the vectors besides the weights.
_SETTINGS = (*_NEEDED, "sentence_bert_config.json", "tokenizer_config.json", "1_Pooling/config.json")
_HOW = f"get it once with `hf download {HUB_NAME} --local-dir FOLDER`, then give retriever=bge_m3 retriever.path=FOLDER"


def bge_folder(path: str = HUB_NAME) -> Path:
    """Folder of the model.

    Args:
        path: a folder, or a name in the Hugging Face cache.

    Raises:
        DataError: neither is there, or files are missing in it; says how to get them.
    """
    folder = Path(path).expanduser()
    if not folder.is_dir():
        folder = _hub_folder(path)
    missing = [name for name in _NEEDED if not (folder / name).is_file()]
    if not any((folder / name).is_file() for name in WEIGHTS):
        missing.append(" or ".join(WEIGHTS))
    if missing:
        raise DataError(f"{folder}: no {', no '.join(missing)}, expected the sentence-transformers folder; {_HOW}")
    return folder


def _hub_folder(path: str) -> Path:
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import HFValidationError, LocalEntryNotFoundError

    try:
        return Path(snapshot_download(path, local_files_only=True))
    except (LocalEntryNotFoundError, HFValidationError):
        what = f"{path}: no such folder, and no model of that name on this machine"
        raise DataError(f"{what} (nothing is downloaded); {_HOW}") from None


class BgeM3:
    """XLM-RoBERTa: the state of the first token is a text's vector, and each of its tokens has a lexical weight."""

    def __init__(self, path: str = HUB_NAME, *, device: str = "cpu") -> None:
        """Choose the weights; nothing is read yet.

        Args:
            path: folder in sentence-transformers layout, or a name in the Hugging Face cache.
            device: where the network runs; equal bytes are promised for ``cpu`` only.
        """
        self._path, self._device = path, device

    @cached_property
    def folder(self) -> Path:
        """Folder of the weights.

        Raises:
            DataError: it is not there.
        """
        return bge_folder(self._path)

    @cached_property
    def name(self) -> str:
        """Name with the start of the hash of weights and settings."""
        weights = next(self.folder / name for name in WEIGHTS if (self.folder / name).is_file())
        files = {name: (self.folder / name) for name in _SETTINGS if (self.folder / name).is_file()}
        parts = {name: sha256_bytes(file.read_bytes()) for name, file in files.items()}
        digest = sha256_bytes(canonical_json(parts | {"weights": remembered_sha256(weights)}).encode())
        return f"bge-m3-{digest[:8]}" + ("" if self._device == "cpu" else f"-{self._device.replace(':', '')}")

    @cached_property
    def sparse_name(self) -> str:
        """Name of the lexical weights, with the start of their head's hash.

        Raises:
            DataError: the head's file is missing.
        """
        head = self.folder / SPARSE_HEAD
        if not head.is_file():
            raise DataError(
                f"{head}: no such file, and without it BGE-M3 gives no lexical weights; add it from {HUB_NAME}, or "
                "give retriever.sparse_weight=0"
            )
        return f"{self.name}-{remembered_sha256(head)[:8]}"

    @cached_property
    def dim(self) -> int:
        """Length of a vector: 1024 for the published model."""
        config = _settings(self.folder / "config.json")
        if config.get("model_type") != "xlm-roberta" or not isinstance(config.get("hidden_size"), int):
            kind = config.get("model_type")
            raise DataError(f"{self.folder}/config.json: model type {kind!r}, expected 'xlm-roberta' (BGE-M3); {_HOW}")
        return int(config["hidden_size"])

    def encode(self, texts: Sequence[str]) -> Vectors:
        """Encode texts, each on its own.

        Returns:
            (n, dim) float32 unit vectors whose values are exact in fp16.
        """
        out = np.empty((len(texts), self.dim), np.float16)
        for i, output in enumerate(self._outputs(texts)):
            out[i] = output["sentence_embedding"][0].float().cpu().numpy()
        return out.astype(np.float32)

    def encode_both(self, texts: Sequence[str], progress: Progress | None = None) -> tuple[Vectors, SparseRows]:
        """Vectors as :meth:`encode` gives them, and lexical weights.

        A token that occurs several times has its largest weight.

        Args:
            texts: n texts.
            progress: called with (texts done, texts in all).
        """
        weight, bias, special = self._head
        vectors = np.empty((len(texts), self.dim), np.float16)
        rows: list[tuple[NDArray[np.int32], NDArray[np.float16]]] = []
        for i, output in enumerate(self._outputs(texts)):
            vectors[i] = output["sentence_embedding"][0].float().cpu().numpy()
            hidden = output["token_embeddings"][0].float()
            reached = (hidden @ weight + bias).clamp_min(0).cpu().numpy().astype(np.float16)  # (T,)
            ids, place = np.unique(output["input_ids"][0].cpu().numpy().astype(np.int32), return_inverse=True)
            most = np.zeros(len(ids), np.float16)
            np.maximum.at(most, place, reached)
            keep = (most > 0) & ~np.isin(ids, special)
            rows.append((ids[keep], most[keep]))
            if progress is not None:
                progress(i + 1, len(texts))
        return vectors.astype(np.float32), SparseRows.stack(rows)

    def _outputs(self, texts: Sequence[str]) -> Iterator[dict[str, Any]]:
        """The model's outputs, one text after the other."""
        if texts:
            with one_thread():
                yield from (_output(self._model, text) for text in texts)

    @cached_property
    def _model(self) -> Any:
        self.dim  # noqa: B018 (raises errors of the configuration before gigabytes are read)
        _check_modules(self.folder / "modules.json")
        os.environ.setdefault("HF_HUB_OFFLINE", "1")
        os.environ.setdefault("TRANSFORMERS_OFFLINE", "1")
        import torch
        import transformers
        from sentence_transformers import SentenceTransformer

        try:
            with quiet(transformers), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                model = SentenceTransformer(
                    str(self.folder),
                    device=self._device,
                    local_files_only=True,
                    trust_remote_code=False,
                    model_kwargs={"dtype": torch.float32, "attn_implementation": "eager"},
                ).eval()
        except Exception as error:  # a damaged file can fail in any way in four libraries
            line = " ".join(str(error).split())[:160]
            raise DataError(f"{self.folder}: cannot be loaded ({type(error).__name__}: {line}); {_HOW}") from None
        self._check(model)
        return model

    def _check(self, model: Any) -> None:
        """Every weight must have come from the file, and the vector of a text must be its first token's, normalised."""
        import torch

        absent = sorted(set(model[0].auto_model.state_dict()) - _tensor_names(self.folder))
        absent = [name for name in absent if not name.startswith("pooler.") and "position_ids" not in name]
        if absent:
            raise DataError(f"{self.folder}: the weights lack {len(absent)} tensors ({absent[0]}, ...); {_HOW}")
        output = _output(model, "habit")
        first = torch.nn.functional.normalize(output["token_embeddings"][0, 0], dim=0)
        if not torch.allclose(first, output["sentence_embedding"][0], atol=1e-5):
            raise DataError(
                f"{self.folder}: modules.json does not pool by the first token with normalisation, as BGE-M3 does; "
                f"{_HOW}"
            )

    @cached_property
    def _head(self) -> tuple[Any, Any, NDArray[np.int32]]:
        """Weight (dim,) and bias () of the lexical head, and the ids of special tokens."""
        import torch

        self.sparse_name  # noqa: B018 (says that the head is missing)
        file = self.folder / SPARSE_HEAD
        try:
            state = torch.load(file, map_location="cpu", weights_only=True)
            found = {name: tuple(state[name].shape) for name in ("weight", "bias")}
        except Exception as error:
            what = f"{file}: not the weight and bias of a linear layer ({type(error).__name__})"
            raise DataError(f"{what}; restore it from {HUB_NAME}, or give retriever.sparse_weight=0") from None
        if found != {"weight": (1, self.dim), "bias": (1,)}:
            raise DataError(
                f"{file}: weight {found['weight']} and bias {found['bias']}, expected {(1, self.dim)} and (1,); "
                f"restore it from {HUB_NAME}, or give retriever.sparse_weight=0"
            )
        device = self._model.device
        special = np.asarray(self._model.tokenizer.all_special_ids, np.int32)
        return state["weight"][0].float().to(device), state["bias"][0].float().to(device), special


def _output(model: Any, text: str) -> dict[str, Any]:
    """States of the tokens, vector and token ids of one text."""
    import torch

    with torch.inference_mode():
        batch = {key: x.to(model.device) if hasattr(x, "to") else x for key, x in model.preprocess([text]).items()}
        return {"input_ids": batch["input_ids"], **model(batch)}


def _check_modules(file: Path) -> None:
    """Refuse a folder that brings a class of its own: some versions of the library would run its code."""
    try:
        kinds = [str(module["type"]) for module in read_json(file, _HOW)]
    except (LookupError, TypeError):
        raise DataError(f"{file}: not a list of modules with their types; {_HOW}") from None
    if odd := next((kind for kind in kinds if not kind.startswith("sentence_transformers.")), None):
        raise DataError(f"{file}: module of type {brief(odd)}, which is code from the folder and is not run; {_HOW}")


def _settings(file: Path) -> dict[str, Any]:
    found = read_json(file, _HOW)
    return found if isinstance(found, dict) else {}


def _tensor_names(folder: Path) -> set[str]:
    """Names of the tensors in the weights' file, as the bare network calls them; their values are not read."""
    file = next(folder / name for name in WEIGHTS if (folder / name).is_file())
    if file.suffix == ".safetensors":
        from safetensors import safe_open

        with safe_open(file, "pt") as tensors:
            names = set(tensors.keys())
    else:
        import torch

        names = set(torch.load(file, map_location="meta", weights_only=True))
    return {name.removeprefix("roberta.") for name in names}
