"""Frozen networks of the transformers library: found on this machine, checked, loaded, never trained.

They are not submodules of the policies that use them, so that only trained weights are stored with a policy.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import torch
from torch import nn

from ucon.core.errors import DataError, brief
from ucon.core.untrusted.weight_files import fingerprint, local_folder, missing_parts


class FrozenWeights:
    """A model in Hugging Face layout; nothing is read before it is needed."""

    def __init__(self, path: str, kind: str, option: str) -> None:
        """Set where the weights are.

        Args:
            path: folder, or a name in the Hugging Face cache.
            kind: class of transformers that reads it, such as ``ResNetModel``.
            option: name of the option with the path, for error messages.
        """
        self.path, self._kind, self._option = str(path), kind, option

    def check(self) -> None:
        """Check that the files are there; reads no weights.

        Raises:
            DataError: no such model here, or files are missing in its folder.
        """
        folder = local_folder(self.path)
        missing = ["folder or cached model of that name"] if folder is None else missing_parts(folder)
        if missing:
            raise DataError(f"{self._option}={self.path}: no {', no '.join(missing)}; {self._how}")

    def fingerprint(self) -> str | None:
        """Hash of the files (:func:`ucon.core.untrusted.weight_files.fingerprint`); None where there are none."""
        folder = local_folder(self.path)
        return None if folder is None else fingerprint(folder)

    @cached_property
    def identity(self) -> str:
        """First 12 digits of the hash of the files.

        Raises:
            DataError: there are none.
        """
        self.check()
        return str(self.fingerprint())[:12]

    @cached_property
    def model(self) -> Any:
        """The model on the CPU, in evaluation mode, without gradients.

        Raises:
            DataError: files that cannot be read, or that lack a tensor (the library would fill it with random numbers).
        """
        self.check()
        import transformers

        from ucon.language.encoder import quiet

        kind = getattr(transformers, self._kind)
        try:
            with quiet(transformers), torch.inference_mode(False):
                model, report = kind.from_pretrained(
                    local_folder(self.path),
                    local_files_only=True,
                    trust_remote_code=False,
                    use_safetensors=True,
                    output_loading_info=True,
                )
        except Exception as error:  # a damaged file fails in many ways
            line = brief(" ".join(str(error).split()))
            raise DataError(
                f"{self._option}={self.path}: cannot be loaded ({type(error).__name__}: {line}); {self._how}"
            ) from None
        if lacking := sorted(report["missing_keys"]):
            raise DataError(f"{self._option}={self.path}: no {self._kind}, it lacks {brief(lacking[0])}; {self._how}")
        frozen: nn.Module = model.eval().requires_grad_(False)
        return frozen

    @property
    def _how(self) -> str:
        return f"get it once with `hf download NAME --local-dir FOLDER` and give {self._option}=FOLDER"

    def __getstate__(self) -> dict[str, Any]:
        return without_models(self, "model")


class ClipTower:
    """Base of CLIP's text and image encoders, whose vectors have the same size.

    Args: as for :class:`FrozenWeights`.
    """

    def __init__(self, path: str, kind: str, option: str) -> None:
        """Set where the weights are; arguments as for :class:`FrozenWeights`."""
        self._weights = FrozenWeights(path, kind, option)

    @property
    def name(self) -> str:
        """``clip`` and a hash of the files."""
        return f"clip {self._weights.identity}"

    @property
    def dim(self) -> int:
        """Size of a vector; loads the weights."""
        return int(self._weights.model.config.projection_dim)

    def check(self) -> None:
        """Raise :class:`DataError` where the files are missing; loads nothing."""
        self._weights.check()

    def fingerprint(self) -> str | None:
        """Hash of the files; None where they are missing."""
        return self._weights.fingerprint()


def without_models(holder: Any, *names: str) -> dict[str, Any]:
    """State of an object for pickling, without attributes that are made on first use.

    Args:
        holder: whose state.
        names: attributes to leave out; another process or device makes its own.
    """
    return {name: value for name, value in vars(holder).items() if name not in names}
