"""Fingerprints of weights depend on bytes, names and sizes but not on times; large files are sampled."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from ucon.core.untrusted import weight_files
from ucon.core.untrusted.weight_files import fingerprint, missing_parts
from ucon.evaluation.playing.needed_weights import check_weights, fingerprints

LARGE = weight_files._WHOLE_BYTES + 12345


def model(folder: Path, fill: bytes = b"a", header: str = "{}") -> Path:
    """A configuration and weights too large to be read whole, with a header as in safetensors."""
    folder.mkdir()
    (folder / "config.json").write_text(json.dumps({"hidden_size": 8}))
    body = len(header).to_bytes(8, "little") + header.encode()
    (folder / "model.safetensors").write_bytes(body + fill * (LARGE - len(body)))
    return folder


def test_a_copy_has_the_same_and_times_do_not_count(tmp_path: Path) -> None:
    first = model(tmp_path / "a")
    second = model(tmp_path / "b")
    os.utime(second / "config.json", (1, 1))
    (second / "README.md").write_text("not a part of the model")
    assert fingerprint(first) == fingerprint(second)


@pytest.mark.parametrize("change", ["config", "weights", "header", "name", "size", "more"])
def test_what_differs_has_another(change: str, tmp_path: Path) -> None:
    header = '{"weight": 1}' if change == "header" else "{}"
    first, second = model(tmp_path / "a"), model(tmp_path / "b", b"b" if change == "weights" else b"a", header)
    weights = second / "model.safetensors"
    if change == "config":
        (second / "config.json").write_text(json.dumps({"hidden_size": 9}))
    elif change == "name":
        weights.rename(second / "other.safetensors")
    elif change == "size":
        weights.write_bytes(weights.read_bytes() + b"a")
    elif change == "more":
        (second / "tokenizer.json").write_text("{}")
    assert fingerprint(first) != fingerprint(second)


def test_of_a_large_file_little_is_read(tmp_path: Path) -> None:
    """A sparse file of a terabyte, which would take long to read."""
    (tmp_path / "model.bin").touch()
    os.truncate(tmp_path / "model.bin", 1 << 40)
    assert len(fingerprint(tmp_path / "model.bin")) == 64


def test_what_a_folder_lacks(tmp_path: Path) -> None:
    assert missing_parts(tmp_path) == ["config.json", "weights (*.safetensors)"]
    assert missing_parts(model(tmp_path / "m")) == []


def test_parts_without_weights_say_nothing_and_missing_ones_say_so() -> None:
    none, there = SimpleNamespace(fingerprint=lambda: ""), SimpleNamespace(fingerprint=lambda: "f")
    gone = SimpleNamespace(fingerprint=lambda: None)
    assert fingerprints(object(), none, there) == ("f",)
    assert fingerprints(there, gone) is None
    check_weights(object())
    with pytest.raises(ZeroDivisionError):
        check_weights(object(), SimpleNamespace(check=lambda: 1 / 0))
