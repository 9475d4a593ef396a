"""VTN has the sizes of its paper's code, and sees what the detector reports."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from models.nets.vision import visual_transformer
from models.nets.vision.local_tokens import LabelTokens, indicator, labels
from models.nets.vision.visual_transformer import VisualTransformer, described, position_code
from models.vtn import VTN, VTNPretraining
from ucon.core.errors import ConfigError, DataError
from ucon.core.files import write_atomic, write_manifest
from ucon.learning.policies.action_policy import Arrays
from ucon.learning.run.network_files import network_files
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections


def count(module: torch.nn.Module) -> int:
    return sum(p.numel() for p in module.parameters())


@pytest.fixture(scope="module")
def vtn() -> VTN:
    return VTN().eval()


def test_sizes_are_those_of_the_paper(vtn: VTN) -> None:
    """17.9 M parameters, not counting the features of categories, which replace DETR."""
    assert count(vtn) - count(vtn.tokens) == 17_888_833
    assert count(vtn.tokens) == (len(labels()) + 1) * 256
    assert vtn.lstm.input_size == 3200
    assert (vtn.lstm.num_layers, vtn.lstm.hidden_size) == (2, 512)
    assert count(vtn.lstm) == 9_707_520
    visual = vtn.visual
    assert (visual.local_embed.in_features, visual.local_embed.out_features) == (256, 249)
    assert tuple(visual.global_embed.weight.shape) == (256, 512, 1, 1)
    assert (len(visual.encoder.layers), len(visual.decoder)) == (6, 6)
    assert [m.out_features for m in visual.regions if isinstance(m, torch.nn.Linear)] == [128, 64]
    assert (vtn.actor.out_features, vtn.action_embed.in_features) == (7, 7)


def test_unused_tokens_count_as_if_each_were_there(monkeypatch):
    torch.manual_seed(0)
    visual = VisualTransformer().eval()
    features, things, maps = torch.rand(4, 100, 256), torch.rand(4, 100, 7), torch.rand(4, 512, 7, 7)
    for frame, used in enumerate((3, 17, 0, 9)):
        features[frame, used:], things[frame, used:] = 0.0, 0.0
    with torch.no_grad():
        short = visual(features, things, maps)
        monkeypatch.setattr(visual_transformer, "merged", lambda f, t: (f, t, torch.zeros(100)))
        assert torch.allclose(short, visual(features, things, maps), atol=1e-5)


def test_a_frame_becomes_3136_numbers() -> None:
    visual = VisualTransformer().eval()
    with torch.inference_mode():
        found = visual(torch.rand(2, 100, 256), torch.rand(2, 100, 7), torch.rand(2, 512, 7, 7))
    assert found.shape == (2, 3136)
    assert not torch.allclose(found[0], found[1])


def test_it_starts_as_its_papers_code_does(vtn: VTN) -> None:
    assert torch.allclose(vtn.actor.weight.norm(dim=1), torch.full((7,), 0.01))
    assert all(torch.allclose(part.weight.norm(dim=1), torch.ones(len(part.weight))) for part in vtn.critic)
    assert not any(bool(p.any()) for n, p in vtn.named_parameters() if "bias" in n and "norm" not in n)
    first, second = (layer.self_attn.in_proj_weight for layer in vtn.visual.encoder.layers[:2])
    assert not torch.equal(first, second)  # layers are not copies of each other
    bound = (6 / (256 + 249)) ** 0.5
    assert 0.99 * bound < vtn.visual.local_embed.weight.abs().max() <= bound


def test_frames_at_once_give_what_the_lstm_gives_step_by_step(vtn: VTN) -> None:
    torch.manual_seed(0)
    frames = {
        "map": torch.rand(5, 2, 512, 7, 7).half(), "label": torch.randint(0, 9, (5, 2, 100), dtype=torch.int16),
        "score": torch.ones(5, 2, 100).half(), "box": torch.rand(5, 2, 100, 4).half(),
    }  # fmt: skip
    context, before = {"target": torch.tensor([3, 4])}, vtn.initial_state(2)
    with torch.no_grad():
        found = vtn(frames, context, before)
        memory = tuple(before[name].transpose(0, 1) for name in ("hidden", "cell"))
        for t, seen in enumerate(vtn.seen(frames, context)):
            acted = torch.relu(vtn.action_embed(before["probabilities"]))
            outputs, memory = vtn.lstm(torch.cat([seen, acted], -1)[None], memory)
            logits = vtn.actor(outputs[0])
            before = {"probabilities": logits.softmax(-1)}
            assert torch.allclose(found.logits[t], logits, atol=1e-7)
    for name, layers in zip(("hidden", "cell"), memory, strict=True):
        assert torch.allclose(found.state[name], layers.transpose(0, 1), atol=1e-5)
    assert float(found.logits.std()) > 1e-5


def test_dropout_is_of_training_and_pretraining_has_none() -> None:
    rates = {m.p for m in VTN().modules() if isinstance(m, torch.nn.Dropout)}
    assert rates == {0.1}
    assert {m.p for m in VTNPretraining().modules() if isinstance(m, torch.nn.Dropout)} == {0.0}
    with pytest.raises(ConfigError, match=r"dropout=1\.0"):
        VTN(dropout=1.0)


def test_positions_are_rows_then_columns() -> None:
    code = position_code(7, 256).view(7, 7, 256)
    assert torch.equal(code[2, 0, :128], code[2, 6, :128])
    assert torch.equal(code[0, 3, 128:], code[6, 3, 128:])
    assert torch.equal(code[4, 4, :128], code[4, 4, 128:])
    assert code[0, 0, :2].tolist() == pytest.approx([np.sin(1), np.cos(1)])
    assert len(code.view(49, 256).unique(dim=0)) == 49


def look(names: list[str], tracks: np.ndarray, score: list[float] | None = None) -> dict[str, torch.Tensor]:
    pixels = [int((tracks == k).sum()) for k in range(len(names))]
    found = SimpleNamespace(track=np.arange(len(names)), category=names, pixels=pixels, score=score)
    arrays = LabelTokens().frame({}, {"detections": found, "tracks": tracks.astype(np.int16)})
    return {name: torch.tensor(array) for name, array in arrays.items()}


def test_tokens_are_the_best_of_each_label_in_order() -> None:
    tracks = np.full((128, 128), -1)
    tracks[0:64, 0:32], tracks[64:128, 32:128], tracks[100:104, 0:8], tracks[0:10, 64:128] = 0, 1, 2, 3
    frame = look(["mug", "bed", "mug", "walls"], tracks)
    numbers = sorted((labels()["bed"], labels()["mug"]))
    assert frame["label"][:2].tolist() == numbers
    assert not frame["label"][2:].any()
    row = numbers.index(labels()["mug"])
    assert frame["box"][row].tolist() == [0, 0, 0.25, 0.5]  # the larger mug
    assert frame["box"][1 - row].tolist() == [0.25, 0.5, 1, 1]
    assert frame["score"][:3].tolist() == [1, 1, 0]
    surer = look(["mug", "bed", "mug", "walls"], tracks, [0.3, 0.5, 0.75, 1.0])
    assert surer["box"][row].tolist() == [0, 100 / 128, 8 / 128, 104 / 128]
    assert surer["score"][row] == 0.75


def test_the_target_is_a_mark_on_its_label_and_nothing_else() -> None:
    label = torch.tensor([[3, 5, 0, 0]] * 2, dtype=torch.int16)
    assert indicator({"label": label}, torch.tensor([5, 0])).tolist() == [[0, 1, 0, 0], [0, 0, 0, 0]]
    things = described(label, 44, torch.zeros(2, 4, 4), torch.ones(2, 4), torch.zeros(2, 4))
    assert things.shape == (2, 4, 7)
    assert things[0, :, 0].tolist() == [1.5, 2.5, 0, 0]  # scaled to the range of VTNet's 22 labels


def test_labels_are_the_catalogue_without_the_building() -> None:
    tokens = LabelTokens()
    assert tokens.n_labels == len(catalogue()) - len(set(catalogue().names) & set(STRUCTURE_KINDS))
    assert tokens.label_of("mug") > 0
    assert tokens.label_of("walls") == tokens.label_of("no such thing") == 0
    assert not tokens.embed.weight[0].any()


def test_without_a_detector_it_says_so() -> None:
    with pytest.raises(ConfigError, match="give detector=gt"):
        LabelTokens().frame({}, {})


def test_it_goes_on_from_pretraining(tmp_path: Path) -> None:
    made = VTNPretraining(seed=3)
    files = network_files(made)
    for name, content in files.items():
        write_atomic(tmp_path / name, content)
    write_manifest(tmp_path, files)
    vtn, fresh = VTN(pretrained=str(tmp_path)), VTN()
    for part in ("visual", "tokens"):
        wanted, found = getattr(made, part).state_dict(), getattr(vtn, part).state_dict()
        assert all(torch.equal(found[name], tensor) for name, tensor in wanted.items())
    assert torch.equal(vtn.lstm.weight_hh_l0, fresh.lstm.weight_hh_l0)
    with pytest.raises(DataError, match="agent=vtn_pretraining learner=imitation"):
        VTN(pretrained=str(tmp_path / "none"))


def stacked(frames: list[Arrays]) -> dict[str, torch.Tensor]:
    """Frames of one episode as tensors (T, 1, ...)."""
    return {name: torch.from_numpy(np.stack([frame[name] for frame in frames]))[:, None] for name in frames[0]}


def test_frozen_its_visual_transformer_looks_once_and_stays(vtn: VTN) -> None:
    """Same outputs and same weights on disk; only the layers after the visual transformer have gradients."""
    frozen, draw = VTN(freeze_visual=True).train(), np.random.default_rng(0)
    tracks = np.zeros((128, 128), np.int16)
    tracks[20:60, 30:90] = 1
    seen = Detections(np.array([0, 1]), ["walls", "mug"], np.array([13_984, 2_400], np.int32), tracks)
    info = {"target": "mug", "detections": seen, "tracks": tracks}
    images = [{"rgb": draw.integers(0, 255, (128, 128, 3), np.uint8)} for _ in range(3)]
    frames, plain = (stacked([policy.frame(one, info) for one in images]) for policy in (frozen, vtn))
    context = {"target": torch.from_numpy(vtn.context(info)["target"])[None]}
    features = frozen.features(frames)
    assert {name: tensor.shape for name, tensor in features.items()} == {"seen": (3, 1, 3136)}
    found = frozen(features, context, frozen.initial_state(1))
    with torch.inference_mode():
        assert torch.allclose(found.logits, vtn(plain, context, vtn.initial_state(1)).logits, atol=1e-5)
    found.logits.square().sum().backward()
    taught = {name for name, value in frozen.named_parameters() if value.grad is not None}
    assert {name.split(".")[0] for name in taught} == {"action_embed", "lstm", "actor"}
    assert not any(value.requires_grad for value in frozen.visual.parameters())
    assert frozen.state_dict().keys() == vtn.state_dict().keys()


def test_the_last_probabilities_are_carried(vtn: VTN) -> None:
    frames = {
        "map": torch.rand(1, 1, 512, 7, 7).half(),
        "label": torch.zeros(1, 1, 100, dtype=torch.int16),
        "score": torch.zeros(1, 1, 100),
        "box": torch.zeros(1, 1, 100, 4),
    }
    context, start = {"target": torch.tensor([1])}, vtn.initial_state(1)
    with torch.inference_mode():
        found = vtn(frames, context, start)
        assert torch.allclose(found.state["probabilities"], found.logits[0].softmax(-1))
        other = vtn(frames, context, {**start, "probabilities": torch.eye(7)[:1]})
    assert not torch.equal(other.logits, found.logits)
