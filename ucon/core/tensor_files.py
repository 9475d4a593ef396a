"""Tensors of others (safetensors): what is in a file is compared with what is wanted before any of it is unpacked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import read_verified
from ucon.core.untrusted.strict_json import JsonError, parse_json

if TYPE_CHECKING:
    from torch import Tensor

#: Kinds of number by their names in files; others are of no use here.
_KINDS: Final = {
    "F64": "float64", "F32": "float32", "F16": "float16", "BF16": "bfloat16", "I64": "int64", "I32": "int32",
    "I16": "int16", "I8": "int8", "U8": "uint8", "BOOL": "bool",
}  # fmt: skip
#: Those that weights may be rounded to.
_ROUNDED: Final = ("float32", "float16", "bfloat16")
_METADATA: Final = "__metadata__"
_MOST_HEADER: Final = 16 << 20


def read_tensors(raw: bytes, path: Path) -> dict[str, Tensor]:
    """The tensors in the bytes of a safetensors file, by name.

    Raises:
        DataError: they are none; a pickle is called one.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        tensors: dict[str, Tensor] = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError, RuntimeError) as error:
        raise _no_tensors(raw, path, str(error)) from None
    return tensors


def read_fitting(path: Path, wanted: Mapping[str, Tensor]) -> tuple[dict[str, Tensor], bytes]:
    """Tensors of the file ``path``, which its folder's manifest lists, and its bytes.

    Args:
        path: a safetensors file.
        wanted: tensors of the same names and shapes. Those of floats may have been rounded to 32 or 16 bits.

    Raises:
        DataError: missing, altered or no safetensors; other names, shapes or kinds of number; or values that are none.
    """
    raw = read_verified(path, 8 * sum(tensor.numel() for tensor in wanted.values()) + _MOST_HEADER)
    check_header(header(raw, path), wanted, path)
    tensors = read_tensors(raw, path)
    check_finite(tensors, path)
    return tensors, raw


def header(raw: bytes, path: Path) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Kind of number and shape of each tensor in a safetensors file, by name; nothing is unpacked.

    Raises:
        DataError: it is none.
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
        raise _no_tensors(raw, path, f"{brief(odd)} is no tensor")
    return {name: entry for name, entry in entries.items() if entry is not None}


def metadata(raw: bytes, path: Path) -> Mapping[str, Any]:
    """What the header says beside tensors.

    Raises:
        DataError: it is no safetensors file.
    """
    header(raw, path)
    found = parse_json(raw[8 : 8 + int.from_bytes(raw[:8], "little")], max_bytes=_MOST_HEADER).get(_METADATA)
    return found if isinstance(found, dict) else {}


def check_header(found: Mapping[str, tuple[str, tuple[int, ...]]], wanted: Mapping[str, Tensor], path: Path) -> None:
    """Refuse other names, shapes or kinds of number.

    Raises:
        DataError: naming the first tensor in ``path`` that does not fit.
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
    """Refuse values that are no numbers.

    Raises:
        DataError: naming the first tensor that has one.
    """
    import torch

    for name, tensor in sorted(tensors.items()):
        if tensor.is_floating_point() and not bool(torch.isfinite(tensor.float()).all()):
            raise DataError(f"{path}: {name} holds values that are no numbers; restore it, or train anew")


def _entry(value: Any) -> tuple[str, tuple[int, ...]] | None:
    if not isinstance(value, dict) or not isinstance(shape := value.get("shape"), list):
        return None
    if not all(type(size) is int and size >= 0 for size in shape):
        return None
    return _KINDS.get(str(value.get("dtype")), brief(str(value.get("dtype")))), tuple(shape)


def _no_tensors(raw: bytes, path: Path, reason: str) -> DataError:
    what = "a pickle, which is never read" if raw[:1] == b"\x80" or raw[:2] == b"PK" else brief(reason)
    return DataError(f"{path}: no safetensors ({what}); restore it, or train anew")
