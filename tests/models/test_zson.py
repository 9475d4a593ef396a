"""ZSON has the sizes of its paper, normalises by running statistics, and is trained on augmented images."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from models.nets.vision.augment import color_jitter, grey, random_shift, turn_hue
from models.nets.vision.group_norm_resnet import GroupNormResNet50, RunningMeanAndVar
from models.zson import ZSON
from ucon.core.errors import ConfigError
from ucon.task.actions import encoded_action


def images(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed))


def drawn(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_sizes_are_those_of_the_paper() -> None:
    """With CLIP instead of 384 numbers they are 14.1 M and 1568; see tests/models/nets/test_frozen.py."""
    zson = ZSON()
    assert sum(p.numel() for p in zson.parameters()) == 12_787_496
    assert zson.lstm.input_size == 512 + 384 + 32
    assert (zson.lstm.num_layers, zson.lstm.hidden_size) == (2, 512)
    assert tuple(zson.last_action.weight.shape) == (8, 32)
    assert [m.out_features for m in zson.visual if isinstance(m, torch.nn.Linear)] == [256, 512]
    assert zson.visual[1].in_features == 2048
    assert (zson.actor.out_features, zson.critic.out_features) == (7, 1)


def test_the_encoder_halves_five_times() -> None:
    encoder = GroupNormResNet50().eval()
    with torch.inference_mode():
        assert encoder(images(2, 3, 128, 128)).shape == (2, 1024, 4, 4)
    norms = [m for m in encoder.modules() if isinstance(m, torch.nn.GroupNorm)]
    assert len(norms) == 53
    assert {m.num_groups for m in norms} == {16}


def test_the_start_is_no_action() -> None:
    zson = ZSON()
    rgb = np.zeros((128, 128, 3), np.uint8)
    given = [int(zson.frame({"rgb": rgb, "last_action": encoded_action(k)}, {})["last_action"]) for k in (7, 0, 6)]
    assert given == [0, 1, 7]
    with pytest.raises(ConfigError, match="without images of 128 pixels"):
        zson.frame({"rgb": rgb[:64], "last_action": encoded_action(0)}, {})


def test_running_statistics_are_those_of_all_images() -> None:
    layer, seen = RunningMeanAndVar(), [0.2 * images(n, 3, 6, 5, seed=n) + 0.1 * n for n in (1, 4, 2)]
    for batch in seen:
        layer.update_statistics(batch)
    together = torch.cat(seen)
    assert torch.allclose(layer.mean.flatten(), together.mean((0, 2, 3)), atol=1e-5)
    assert torch.allclose(layer.variance.flatten(), together.var((0, 2, 3), unbiased=False), atol=1e-5)
    assert int(layer.count) == 7
    before = layer.mean.clone()
    found = layer.train()(together)
    assert torch.equal(layer.mean, before)
    assert torch.allclose(found.mean((0, 2, 3)), torch.zeros(3), atol=1e-4)
    assert torch.allclose(found.std((0, 2, 3)), torch.ones(3), atol=0.01)


def test_colours_change_alike_within_an_episode_and_otherwise_between() -> None:
    still = images(1, 1, 3, 8, 8).expand(3, 2, -1, -1, -1)
    found = color_jitter(still, 0.3, drawn())
    assert torch.equal(found[0], found[2])
    assert not torch.allclose(found[:, 0], found[:, 1], atol=0.01)
    assert float(found.min()) >= 0
    assert float(found.max()) <= 1
    assert torch.equal(color_jitter(still, 0.3, drawn()), found)
    assert torch.allclose(color_jitter(still, 0.0, drawn()), still, atol=1e-5)


def test_the_hue_turns_about_grey() -> None:
    some = images(1, 1, 3, 4, 4)
    turned = turn_hue(some, torch.tensor([0.3]))
    assert torch.allclose(grey(turned), grey(some), atol=1e-4)
    assert not torch.allclose(turned, some, atol=0.05)
    assert torch.allclose(turn_hue(turned, torch.tensor([-0.3])), some, atol=1e-4)
    plain = torch.full((1, 1, 3, 2, 2), 0.4)
    assert torch.allclose(turn_hue(plain, torch.tensor([0.3])), plain, atol=1e-2)


def test_shifts_move_whole_images_and_repeat_the_border() -> None:
    still = images(1, 1, 3, 16, 16).expand(2, 12, -1, -1, -1)
    found = random_shift(still, 4, drawn())
    assert found.shape == still.shape
    assert torch.equal(found[0], found[1])
    padded = torch.nn.functional.pad(still[0, :1], (4, 4, 4, 4), mode="replicate")[0]
    places = [
        [(y, x) for y in range(9) for x in range(9) if torch.equal(part, padded[:, y : y + 16, x : x + 16])]
        for part in found[0]
    ]
    assert all(len(place) == 1 for place in places)
    assert len({place[0] for place in places}) > 5
    assert torch.equal(random_shift(still, 0, drawn()), still)
