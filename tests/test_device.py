"""Where and how torch computes: `auto` is resolved by the device alone."""

import pytest
import torch

from ucon.core.device import batch_size, cpu_precision, torch_device, torch_precision
from ucon.core.errors import ConfigError


@pytest.fixture
def card(monkeypatch):
    """Make torch report one GPU, whose compute capability can be set."""
    found = {"capability": (9, 0)}
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    monkeypatch.setattr(torch.cuda, "get_device_capability", lambda device=None: found["capability"])
    return found


def test_a_gpu_is_found_and_used(card):
    assert torch_device("auto") == "cuda"
    assert torch_precision("auto", "cuda") == torch_precision("auto", "cuda:0") == torch.bfloat16
    assert batch_size("auto", "cuda:0", on_cpu=8) == 32


def test_a_card_without_bfloat16_stays_with_float32(card):
    card["capability"] = (7, 5)
    assert torch_precision("auto", "cuda") == torch.float32
    assert torch_precision("bfloat16", "cuda") == torch.bfloat16, "what is asked for is what is done"


def test_on_a_cpu_auto_is_what_it_was(card, monkeypatch):
    assert torch_precision("auto", torch_device("cpu")) == torch.float32
    for has in (True, False):
        monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda has=has: has)
        monkeypatch.setattr(torch.cpu, "_is_amx_tile_supported", lambda: False)
        assert torch_precision("auto", "cpu", on_cpu=True) == (torch.bfloat16 if has else torch.float32)
    assert batch_size("auto", "cpu", on_cpu=8) == 8
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert torch_device("auto") == "cpu"


def test_what_is_given_is_taken(card):
    assert [batch_size(5, device, on_cpu=8) for device in ("cpu", "cuda")] == [5, 5]
    assert torch_precision("float32", "cuda") == torch.float32


@pytest.mark.parametrize("name", ["float16", "Auto", None, ["bfloat16"]])
def test_unknown_precisions_are_refused(name):
    with pytest.raises(ConfigError, match="unknown precision") as caught:
        torch_precision(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("has", [True, False])
def test_halves_are_multiplied_where_the_processor_can(has, monkeypatch):
    monkeypatch.setattr(torch.ops.mkldnn, "_is_mkldnn_bf16_supported", lambda: has)
    assert cpu_precision(torch.bfloat16) == (torch.bfloat16 if has else torch.float32)
    assert cpu_precision(torch.float32) == torch.float32
