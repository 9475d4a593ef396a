"""Safetensors files: names, shapes and types are checked in the header before anything is unpacked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import read_verified
from ucon.core.untrusted.strict_json import JsonError, parse_json

if TYPE_CHECKING:
    from torch import Tensor

#: Number types by their names in files; others are refused.
_KINDS: Final = {
    "F64": "float64", "F32": "float32", "F16": "float16", "BF16": "bfloat16", "I64": "int64", "I32": "int32",
    "I16": "int16", "I8": "int8", "U8": "uint8", "BOOL": "bool",
}  # fmt: skip
#: Types that float weights may be stored in.
_ROUNDED: Final = ("float32", "float16", "bfloat16")
_METADATA: Final = "__metadata__"
_MOST_HEADER: Final = 16 << 20


def read_tensors(raw: bytes, path: Path) -> dict[str, Tensor]:
    """The tensors in the bytes of a safetensors file, by name.

    Args:
        raw: the bytes.
        path: of the file, for errors.

    Raises:
        DataError: they are not safetensors; a pickle is named as such.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        tensors: dict[str, Tensor] = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError, RuntimeError) as error:
        raise _no_tensors(raw, path, str(error)) from None
    return tensors


def read_fitting(path: Path, wanted: Mapping[str, Tensor]) -> tuple[dict[str, Tensor], bytes]:
    """Read a safetensors file that its folder's manifest lists.

    Args:
        path: the file.
        wanted: tensors with the expected names and shapes. Floats may have been rounded to 32 or 16 bits.

    Returns:
        Tensors by name, and the file's bytes.

    Raises:
        DataError: missing, altered or not safetensors; other names, shapes or types; values that are not finite.
    """
    raw = read_verified(path, 8 * sum(tensor.numel() for tensor in wanted.values()) + _MOST_HEADER)
    check_header(header(raw, path), wanted, path)
    tensors = read_tensors(raw, path)
    check_finite(tensors, path)
    return tensors, raw


def header(raw: bytes, path: Path) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Type and shape of each tensor of a safetensors file, by name; nothing is unpacked.

    Args:
        raw: the bytes.
        path: of the file, for errors.

    Raises:
        DataError: it is not a safetensors file.
    """
    size = int.from_bytes(raw[:8], "little")
    try:
        if len(raw) < 8 or size > len(raw) - 8:
            raise JsonError("its header is cut off")
        found = parse_json(raw[8 : 8 + size], max_bytes=_MOST_HEADER)
    except JsonError as error:
        raise _no_tensors(raw, path, str(error)) from None
    if not isinstance(found, dict):
        raise _no_tensors(raw, path, "its header names no tensors")
    entries = {name: _entry(value) for name, value in found.items() if name != _METADATA}
    if odd := next((name for name, entry in entries.items() if entry is None), None):
        raise _no_tensors(raw, path, f"{brief(odd)} is not a tensor")
    return {name: entry for name, entry in entries.items() if entry is not None}


def metadata(raw: bytes, path: Path) -> Mapping[str, Any]:
    """The metadata in the header of a safetensors file; empty without any.

    Args:
        raw: the bytes.
        path: of the file, for errors.

    Raises:
        DataError: it is not a safetensors file.
    """
    header(raw, path)
    found = parse_json(raw[8 : 8 + int.from_bytes(raw[:8], "little")], max_bytes=_MOST_HEADER).get(_METADATA)
    return found if isinstance(found, dict) else {}


def check_header(found: Mapping[str, tuple[str, tuple[int, ...]]], wanted: Mapping[str, Tensor], path: Path) -> None:
    """Check names, shapes and types.

    Args:
        found: type and shape by name, as :func:`header` returns them.
        wanted: tensors with the expected names, shapes and types.
        path: of the file, for errors.

    Raises:
        DataError: naming the first tensor that does not fit.
    """
    if odd := sorted(wanted.keys() ^ found.keys()):
        what = "lacks" if odd[0] in wanted else "has the unknown"
        raise DataError(f"{path}: {what} tensor {brief(odd[0])} ({len(odd)} differ); it belongs to another version")
    for name, (kind, shape) in sorted(found.items()):
        expected, own = tuple(wanted[name].shape), str(wanted[name].dtype).removeprefix("torch.")
        if shape != expected:
            raise DataError(f"{path}: {name} is {brief(shape)}, expected {expected}; it belongs to another version")
        if kind != own and not (wanted[name].is_floating_point() and kind in _ROUNDED):
            raise DataError(f"{path}: {name} is {kind}, expected {own}; it belongs to another version")


def check_finite(tensors: Mapping[str, Tensor], path: Path) -> None:
    """Check that all values are finite.

    Raises:
        DataError: naming the first tensor with a value that is not.
    """
    import torch

    for name, tensor in sorted(tensors.items()):
        if tensor.is_floating_point() and not bool(torch.isfinite(tensor.float()).all()):
            raise DataError(f"{path}: {name} holds values that are not finite; restore it, or train again")


def _entry(value: Any) -> tuple[str, tuple[int, ...]] | None:
    if not isinstance(value, dict) or not isinstance(shape := value.get("shape"), list):
        return None
    if not all(type(size) is int and size >= 0 for size in shape):
        return None
    return _KINDS.get(str(value.get("dtype")), brief(str(value.get("dtype")))), tuple(shape)


def _no_tensors(raw: bytes, path: Path, reason: str) -> DataError:
    what = "a pickle, which is never read" if raw[:1] == b"\x80" or raw[:2] == b"PK" else brief(reason)
    return DataError(f"{path}: not a safetensors file ({what}); restore it, or train again")
