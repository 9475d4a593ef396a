"""Weights of Hugging Face models on this machine: found, checked and loaded, with one-line errors."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DataError, unknown_name
from ucon.core.free_memory import free_bytes
from ucon.core.untrusted.weight_files import FETCHED, fingerprint, local_folder, missing_parts, parameters_in
from ucon.language.encoder import quiet
from ucon.language.packaged import MODELS, PackagedModel

#: Bytes of a weight, by number format.
_BYTES: Final = {"float32": 4, "bfloat16": 2, "float16": 2, "int8": 1}
DTYPES: Final = tuple(_BYTES)


class LocalWeights:
    """One model by folder or name, with device and number format. Nothing is read before it is needed."""

    def __init__(self, path: str, *, device: str = "cpu", dtype: str = "float32", download: bool = False) -> None:
        """Choose the weights.

        Args:
            path: folder in Hugging Face layout, a name in the Hugging Face cache, or a fetched model (``smollm2``).
            device: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.
            dtype: ``float32``, ``bfloat16``, ``float16``, or ``int8`` (bitsandbytes, on a GPU).
            download: fetch a name that is not in the cache from the hub.

        Raises:
            ConfigError: no path, or an unknown dtype.
        """
        if not path:
            raise ConfigError("language model without a path; give language.path=FOLDER or a name on the hub")
        if dtype not in DTYPES:
            raise ConfigError(unknown_name("dtype", dtype, DTYPES))
        self.path, self.dtype = path, dtype
        self._device, self._download = device, download

    @property
    def short(self) -> str:
        """Last part of the path, ``roberta-large``, or the title of a fetched model."""
        return self._packaged.title if self._packaged else Path(self.path).name or self.path

    @property
    def device(self) -> str:
        """The device, as torch names it.

        Raises:
            ConfigError: there is no such device here.
        """
        return torch_device(self._device, "language.device")

    def check(self) -> None:
        """Check that files, device and number format are there; reads no weights.

        Raises:
            DataError: no such model here, or files are missing in its folder.
            ConfigError: a device or number format that this machine lacks, or too little memory.
        """
        folder, device = self.folder(), self.device
        if self.dtype == "int8" and (importlib.util.find_spec("bitsandbytes") is None or not device.startswith("cuda")):
            raise ConfigError(
                f"{self.path}: dtype=int8 needs the package bitsandbytes and a GPU (device is {device}); install it "
                "and give language.device=cuda, or give language.dtype=bfloat16"
            )
        needed, free = parameters_in(folder) * _BYTES[self.dtype], free_bytes()
        if device == "cpu" and free is not None and needed > free:
            raise ConfigError(
                f"{self.path}: its weights take {needed / 1e9:.1f} GB in {self.dtype}, {free / 1e9:.1f} GB of memory "
                "are free; give language.dtype=bfloat16, fewer workers= (each loads its own), or a smaller model"
            )

    def fingerprint(self) -> str | None:
        """Checksum of the files (:func:`ucon.core.untrusted.weight_files.fingerprint`); None where there are none.

        That of a fetched model is the hash of the file it was made of: its folder differs between versions of
        transformers.
        """
        if self._packaged:
            return self._packaged.gguf_sha256 if self._packaged.fetched else None
        folder = local_folder(self.path)
        return None if folder is None else fingerprint(folder)

    def folder(self) -> Path:
        """Folder of the files.

        Raises:
            DataError: they are not all there.
        """
        if self._packaged:
            return self._packaged.require()
        found = Path(self.path).expanduser()
        if not found.is_dir():
            found = self._from_hub()
        if missing := missing_parts(found):
            what = f"{found}: no {', no '.join(missing)}, expected a model in Hugging Face layout"
            raise DataError(f"{what}; {self._how}")
        return found

    def load(self, kind: str) -> Any:
        """Load the model in evaluation mode.

        Args:
            kind: name of the transformers class, such as ``AutoModelForCausalLM``.

        Raises:
            DataError: the files are missing or damaged.
            ConfigError: a device or number format that this machine lacks.
        """
        self.check()
        import torch
        import transformers

        options: dict[str, Any] = {"dtype": torch.float16 if self.dtype == "int8" else getattr(torch, self.dtype)}
        if self.dtype == "int8":
            options["quantization_config"] = transformers.BitsAndBytesConfig(load_in_8bit=True)
            options["device_map"] = {"": self.device}
        model = self.read(lambda folder, **safe: getattr(transformers, kind).from_pretrained(folder, **options, **safe))
        return (model if self.dtype == "int8" else model.to(self.device)).eval()

    def read(self, build: Callable[..., Any]) -> Any:
        """Call ``build`` on the folder, with options that run no code from it and do not use the network.

        Args:
            build: such as ``AutoTokenizer.from_pretrained``.

        Raises:
            DataError: whatever error a damaged file causes.
        """
        import transformers

        folder = self.folder()
        try:
            with quiet(transformers):
                return build(folder, local_files_only=True, trust_remote_code=False)
        except Exception as error:
            line = " ".join(str(error).split())[:200]
            raise DataError(f"{folder}: cannot be loaded ({type(error).__name__}: {line}); {self._how}") from None

    @property
    def _packaged(self) -> PackagedModel | None:
        """The packaged model that the path names, if any."""
        return MODELS.get(self.path)

    @property
    def _how(self) -> str:
        return "get it once with `hf download NAME --local-dir FOLDER` and give language.path=FOLDER"

    def _from_hub(self) -> Path:
        from huggingface_hub import snapshot_download

        try:
            return Path(snapshot_download(self.path, local_files_only=not self._download, allow_patterns=list(FETCHED)))
        except Exception as error:  # the hub's client raises many kinds: offline, no such name, a licence not accepted
            if self._download:
                line = " ".join(str(error).split())[:160]
                what = f"{self.path}: no such folder, and the hub gave no model ({type(error).__name__}: {line})"
                raise DataError(f"{what}; {self._how}") from None
            what = f"{self.path}: no such folder, and no model of that name on this machine"
            raise DataError(f"{what} (nothing is downloaded unless language.download=true); {self._how}") from None
