"""Weights of a network in a folder: whole and of the right network, or refused with one line that says why."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from safetensors.torch import load, save
from torch import nn

from ucon.core.errors import DataError
from ucon.core.files import MANIFEST, write_atomic, write_manifest
from ucon.learning.run.network_files import CONFIG, MAX_HABITS, WEIGHTS, load_network, model_folder, network_files


class Net(nn.Module):
    architecture = "net"

    def __init__(self, width: int = 3, tokens: str = "gt") -> None:
        super().__init__()
        self.linear = nn.Linear(width, 2)
        self.register_buffer("count", torch.tensor(100_000))  # more than fp16 can represent
        self.arguments = {"tokens": tokens}


class Other(Net):
    architecture = "other"


def written(folder: Path, files: dict[str, bytes]) -> Path:
    for name, content in files.items():
        write_atomic(folder / name, content)
    write_manifest(folder, files)
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    torch.manual_seed(0)
    return written(tmp_path / "run" / "model", network_files(Net()))


def change(folder: Path, name: str, make: Callable[[bytes], bytes], *, sealed: bool) -> None:
    """Change a file; with ``sealed``, also the manifest, as only its maker could."""
    (folder / name).write_bytes(make((folder / name).read_bytes()))
    if sealed:
        write_manifest(folder, (WEIGHTS, CONFIG))


@pytest.mark.parametrize("half", [False, True])
def test_what_was_saved_comes_back(half: bool, tmp_path: Path) -> None:
    made, found = Net(), Net()
    found.count.zero_()
    at = written(tmp_path, network_files(made, half=half))
    digest = load_network(str(at), found)
    assert digest == json.loads((at / MANIFEST).read_text())["files"][WEIGHTS]["sha256"]
    wanted = made.linear.weight.half().float() if half else made.linear.weight
    assert torch.equal(found.linear.weight, wanted)
    assert found.linear.weight.dtype == torch.float32
    assert found.count == 100_000


def test_how_many_habits_it_learned_from_comes_back_with_it(folder: Path, tmp_path: Path) -> None:
    made, found = Net(), Net()
    made.max_habits, found.max_habits = 1500, MAX_HABITS
    load_network(str(written(tmp_path, network_files(made))), found)
    assert found.max_habits == 1500
    load_network(str(folder), found)  # a file without this number
    assert found.max_habits == MAX_HABITS
    change(folder, CONFIG, lambda raw: raw.replace(b'"format"', b'"max_habits": "many", "format"'), sealed=True)
    with pytest.raises(DataError, match="does not describe a network"):
        load_network(str(folder), found)


def test_equal_networks_are_equal_bytes_and_halves_are_half() -> None:
    big = Net(width=10_000)
    assert network_files(big) == network_files(big)
    assert len(network_files(big, half=True)[WEIGHTS]) < 0.51 * len(network_files(big)[WEIGHTS])


def test_a_run_is_its_model_folder(folder: Path) -> None:
    assert model_folder(str(folder.parent)) == model_folder(str(folder)) == folder
    load_network(str(folder.parent), Net())


SEALED: dict[str, tuple[str, Callable[[bytes], bytes], str]] = {
    "pickle": (WEIGHTS, lambda raw: pickle.dumps({"linear.weight": 1}), "a pickle, which is never read"),
    "torch.save": (WEIGHTS, lambda raw: b"PK\x03\x04" + raw, "a pickle, which is never read"),
    "nothing": (WEIGHTS, lambda raw: b"", "not a safetensors file"),
    "cut": (WEIGHTS, lambda raw: raw[:-1], "not a safetensors file"),
    "shape": (WEIGHTS, lambda raw: network_files(Net(4))[WEIGHTS], r"linear.weight is \(2, 4\), expected \(2, 3\)"),
    "less": (WEIGHTS, lambda raw: save({"linear.bias": torch.zeros(2)}), "lacks tensor count"),
    "more": (WEIGHTS, lambda raw: save(load(raw) | {"z": torch.zeros(2)}), "has the unknown tensor z"),
    "kind": (
        WEIGHTS,
        lambda raw: save(load(raw) | {"linear.bias": torch.zeros(2, dtype=torch.int64)}),
        "linear.bias is int64, expected float32",
    ),
    "nan": (WEIGHTS, lambda raw: save(load(raw) | {"linear.bias": torch.tensor([0, torch.nan])}), "not finite"),
    "architecture": (CONFIG, lambda raw: network_files(Other())[CONFIG], "of architecture other, expected net"),
    "arguments": (
        CONFIG,
        lambda raw: network_files(Net(tokens="detr"))[CONFIG],
        "tokens=detr, the agent has",
    ),
    "format": (CONFIG, lambda raw: raw.replace(b'"format": 1', b'"format": 2'), "format 2, this version reads 1"),
    "no json": (CONFIG, lambda raw: b"{", "does not describe a network"),
    "no object": (CONFIG, lambda raw: b"[1]", "does not describe a network"),
    "deep": (CONFIG, lambda raw: b"[" * 100_000, "does not describe a network"),
    "no text": (CONFIG, lambda raw: b"\xff\xfe", "does not describe a network"),
}


@pytest.mark.parametrize("name", SEALED)
def test_weights_that_do_not_fit_are_refused(name: str, folder: Path) -> None:
    file, make, message = SEALED[name]
    change(folder, file, make, sealed=True)
    refused(folder, message)


DAMAGED: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda raw: raw[: len(raw) // 2],
    "flipped": lambda raw: raw[:-1] + bytes([raw[-1] ^ 1]),
    "empty": lambda raw: b"",
    "pickle": lambda raw: pickle.dumps(1),
}


@pytest.mark.parametrize("file", [WEIGHTS, CONFIG])
@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_files_are_refused(name: str, file: str, folder: Path) -> None:
    change(folder, file, DAMAGED[name], sealed=False)
    refused(folder, "truncated or altered")


@pytest.mark.parametrize(
    ("file", "message"),
    [(WEIGHTS, "no such file"), (MANIFEST, "cannot be verified"), (CONFIG, "no trained weights")],
)
def test_missing_files_are_named(file: str, message: str, folder: Path) -> None:
    (folder / file).unlink()
    refused(folder, message)


def test_where_there_is_nothing_it_says_how_to_get_it(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"no trained weights there.*; train it") as caught:
        load_network(str(tmp_path / "none"), Net(), how="train it")
    assert "\n" not in str(caught.value)


def test_weights_of_a_training_that_has_not_ended_are_refused(tmp_path: Path) -> None:
    (tmp_path / "checkpoints").mkdir()
    with pytest.raises(DataError, match=r"its training has not ended; continue with `python train\.py resume="):
        load_network(str(tmp_path), Net(), how="train it")


def test_what_is_no_number_is_not_saved() -> None:
    net = Net()
    with torch.no_grad():
        net.linear.weight[0, 0] = 1e5
    network_files(net)
    with pytest.raises(DataError, match=r"linear\.weight is not finite in torch\.float16"):
        network_files(net, half=True)


def refused(folder: Path, message: str) -> None:
    """Assert that loading is refused in one line and leaves the network unchanged."""
    network = Net()
    before = {name: tensor.clone() for name, tensor in network.state_dict().items()}
    with pytest.raises(DataError, match=message) as caught:
        load_network(str(folder), network)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400 + len(str(folder))
    assert all(torch.equal(before[name], tensor) for name, tensor in network.state_dict().items())
