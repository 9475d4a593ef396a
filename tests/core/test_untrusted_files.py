"""Reading files from others: plain files, tensors and arrays stay within their limits, or are refused in one line."""

import json
import os

import pytest
import torch
from safetensors.torch import load, save

from ucon.core.errors import DataError
from ucon.core.files import MANIFEST, read_verified, write_manifest
from ucon.core.tensor_files import read_fitting, read_tensors
from ucon.core.untrusted.plain_file import read_plain

WANTED = {"w": torch.zeros(2, 3), "n": torch.tensor(7)}


def in_a_line(error):
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600


def test_what_is_no_plain_file_is_not_waited_for(tmp_path):
    (tmp_path / "file").write_bytes(b"1234")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    assert read_plain(tmp_path / "file", 4) == read_plain(tmp_path / "link", 4) == b"1234"
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name, message in (("file", "at most 3"), ("pipe", "a pipe"), ("folder", "a folder"), ("file/x", "cannot be")):
        with pytest.raises(DataError, match=message) as caught:
            read_plain(tmp_path / name, 3)
        in_a_line(caught)
    with pytest.raises(DataError, match="a device"):
        read_plain(tmp_path / "/dev/zero", 3)
    with pytest.raises(FileNotFoundError):
        read_plain(tmp_path / "none", 3)


@pytest.mark.parametrize(
    "content",
    ["[", "[]", '{"files": 3}', '{"files": {"a": {}}}', '{"files": {"a": {"sha256": "x", "bytes": "4"}}}', "[" * 9999,
     '{"files": {"a": {"sha256": "x", "bytes": 1e999}}}', '{"files": {"a": {"sha256": "x", "bytes": NaN}}}'],
)  # fmt: skip
def test_manifests_that_are_none(tmp_path, content):
    (tmp_path / "a").write_bytes(b"1234")
    (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(DataError, match=r"no usable entry for a|not a usable manifest") as caught:
        read_verified(tmp_path / "a")
    in_a_line(caught)
    (tmp_path / MANIFEST).unlink()
    (tmp_path / MANIFEST).mkdir()
    with pytest.raises(DataError, match=r"MANIFEST.*folder"):
        read_verified(tmp_path / "a")


def test_a_file_of_another_size_is_not_read(tmp_path):
    (tmp_path / "a").write_bytes(b"1234")
    write_manifest(tmp_path, ["a"])
    with pytest.raises(DataError, match="has 4 bytes, expected at most 3"):
        read_verified(tmp_path / "a", 3)
    with (tmp_path / "a").open("r+b") as file:
        file.truncate(1 << 42)
    with pytest.raises(DataError, match=f"{1 << 42} bytes, expected 4; .*truncated or altered"):
        read_verified(tmp_path / "a")


def sealed(folder, raw):
    (folder / "a.safetensors").write_bytes(raw)
    write_manifest(folder, ["a.safetensors"])
    return folder / "a.safetensors"


@pytest.mark.parametrize("kind", [torch.float32, torch.float16, torch.bfloat16])
def test_weights_may_be_rounded(tmp_path, kind):
    right = {"w": torch.ones(2, 3, dtype=kind), "n": torch.tensor(8)}
    tensors, raw = read_fitting(sealed(tmp_path, save(right)), WANTED)
    assert tensors["w"].dtype == kind
    assert load(raw).keys() == WANTED.keys()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"w": torch.zeros(3, 2)}, r"w is \(3, 2\), expected \(2, 3\)"),
        ({"w": torch.zeros(2, 3, dtype=torch.int64)}, "w is int64, expected float32"),
        ({"w": torch.zeros(2, 3, dtype=torch.float64)}, "w is float64, expected float32"),
        ({"w": torch.zeros(2, 3, dtype=torch.complex64)}, "w is C64, expected float32"),
        ({"n": torch.tensor(7, dtype=torch.int32)}, "n is int32, expected int64"),
        ({"n": torch.tensor(7.0)}, "n is float32, expected int64"),
        ({"w": torch.full((2, 3), torch.inf)}, "not finite"),
        ({"x" * 500: torch.zeros(1)}, r"unknown tensor x+\.\.\."),
    ],
)
def test_tensors_that_do_not_fit(tmp_path, change, message):
    path = sealed(tmp_path, save(WANTED | change))
    with pytest.raises(DataError, match=message) as caught:
        read_fitting(path, WANTED)
    in_a_line(caught)


def test_headers_are_compared_before_anything_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("safetensors.torch.load", lambda raw: pytest.fail("it was unpacked"))
    for entry in ({"dtype": "F32", "shape": [1] * 5000, "data_offsets": [0, 24]},
                  {"dtype": "F32", "shape": [1 << 40, 1 << 40], "data_offsets": [0, 24]},
                  {"dtype": "F32", "shape": [2.0, 3], "data_offsets": [0, 24]}, 7):  # fmt: skip
        header = json.dumps({"w": entry, "n": {"dtype": "I64", "shape": [], "data_offsets": [24, 32]}}).encode()
        path = sealed(tmp_path, len(header).to_bytes(8, "little") + header + bytes(32))
        with pytest.raises(DataError, match=r"w is|w is not a tensor") as caught:
            read_fitting(path, WANTED)
        in_a_line(caught)
    with pytest.raises(DataError, match="expected at most"):
        read_fitting(sealed(tmp_path, bytes(17 << 20)), WANTED)


@pytest.mark.parametrize("raw", [b"", b"\0" * 7, b"\xff" * 100, b"\x80\x04N.", b"PK\x03\x04"])
def test_what_holds_no_tensors(tmp_path, raw):
    for read in (lambda: read_tensors(raw, tmp_path), lambda: read_fitting(sealed(tmp_path, raw), WANTED)):
        with pytest.raises(DataError, match="not a safetensors file") as caught:
            read()
        in_a_line(caught)
