"""Properties of every configured network over the seven actions, whatever its architecture."""

from __future__ import annotations

import pickle
from functools import cache
from typing import Any

import pytest
import torch
from torch import Tensor

from models.nets.policy_defaults import PolicyModule
from models.zson import ZSON
from tests.models.playing import POLICIES, built, config_of, episodes
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.core.files import write_atomic, write_manifest
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.policies.action_policy import PolicyOutputs, Tensors
from ucon.learning.run.network_files import load_network, network_files
from ucon.task.actions import encoded_action

#: Self-attention in the first decoder layer of DETR and VTN attends to zeros: its joint projections never learn, and
#: the layers after them learn only once the biases, which start at zero, have changed.
FIRST = "visual.decoder.0."
IDLE = {f"{FIRST}self_attention.in_proj_weight", f"{FIRST}self_attention.out_proj.weight", f"{FIRST}norms.0.weight"}


@cache
def policy(name: str) -> PolicyModule:
    return Factory(config_of(name)["agent"]["policy"])().eval()


@cache
def sequence(name: str, steps: int = 3, batch: int = 2) -> tuple[Tensors, Tensors]:
    """Frames (T, B, ...) and contexts (B, ...) of the first steps of episodes."""
    found, contexts = [], []
    env = UcONEnv("mini", observe="pixels", detector=True)
    for episode in episodes(batch):
        obs, info = env.reset(options={"episode": episode})
        contexts.append(policy(name).context(info))
        frames = []
        for step in range(steps):
            frames.append(policy(name).frame(obs, info))
            obs, _, _, _, info = env.step(1 + step % 2 * 3)
        found.append({key: torch.stack([torch.tensor(frame[key]) for frame in frames]) for key in frames[0]})
    env.close()
    frames_of = {key: torch.stack([part[key] for part in found], 1) for key in found[0]}
    return frames_of, {key: torch.stack([torch.tensor(c[key]) for c in contexts]) for key in contexts[0]}


def at(frames: Tensors, step: int) -> dict[str, Tensor]:
    return {name: tensor[step : step + 1] for name, tensor in frames.items()}


def run(name: str, frames: Tensors, context: Tensors, state: Any = None) -> PolicyOutputs:
    with torch.inference_mode():
        return policy(name)(frames, context, policy(name).initial_state(2) if state is None else state)


def test_there_are_policies_to_test() -> None:
    assert {"vtn", "vtn_pretraining", "zson"} <= set(POLICIES)


@pytest.mark.parametrize("name", POLICIES)
def test_shapes_are_those_of_the_protocol(name: str) -> None:
    frames, context = sequence(name)
    found = run(name, frames, context)
    assert found.logits.shape == (3, 2, 7)
    assert found.value.shape == (3, 2)
    assert found.logits.dtype == found.value.dtype == torch.float32
    start = policy(name).initial_state(2)
    assert {key: t.shape for key, t in found.state.items()} == {key: t.shape for key, t in start.items()}
    assert all(len(tensor) == 2 for tensor in start.values())


@pytest.mark.parametrize("name", POLICIES)
def test_steps_together_are_steps_one_by_one(name: str) -> None:
    frames, context = sequence(name)
    together, state, alone = run(name, frames, context), None, []
    for step in range(3):
        alone.append(run(name, at(frames, step), context, state))
        state = alone[-1].state
    assert torch.allclose(torch.cat([o.logits for o in alone]), together.logits, atol=1e-5)
    assert torch.allclose(torch.cat([o.value for o in alone]), together.value, atol=1e-4)
    for key, tensor in together.state.items():
        assert torch.allclose(alone[-1].state[key], tensor, atol=1e-5)
    if together.state:  # without its memory, the value differs
        forgot = run(name, at(frames, 2), context)
        assert not torch.allclose(forgot.value, together.value[2:], atol=1e-4)


@pytest.mark.parametrize("name", POLICIES)
def test_in_bfloat16_it_says_nearly_the_same_in_float32(name: str) -> None:
    frames, context = sequence(name)
    wanted = run(name, frames, context)
    with torch.autocast("cpu", torch.bfloat16):
        found = run(name, frames, context)
    said = (found.logits, found.value, *found.state.values())
    kinds = {t.dtype for t in said if t.is_floating_point()}
    assert kinds == {torch.float32}
    assert (found.logits - wanted.logits).abs().max() < 0.1 * wanted.logits.abs().max()


@pytest.mark.parametrize("name", POLICIES)
def test_episodes_of_a_batch_know_nothing_of_each_other(name: str) -> None:
    frames, context = sequence(name)
    together = run(name, frames, context)
    other = {key: torch.cat([t[:, :1], torch.zeros_like(t[:, 1:])], 1) for key, t in frames.items()}
    changed = run(name, other, context)
    assert torch.allclose(changed.logits[:, 0], together.logits[:, 0], atol=1e-5)
    assert not torch.allclose(changed.logits[:, 1], together.logits[:, 1], atol=1e-6)


@pytest.mark.parametrize("name", POLICIES)
def test_the_target_changes_the_answer(name: str) -> None:
    frames, context = sequence(name)
    seen = frames["label"][0, :, 0] if "label" in frames else None  # makes the first thing in view the target
    other = (
        {"target": seen.long()}
        if seen is not None
        else {key: context[key].flip(0) for key in {"target", "goal"} & set(context)}
    )
    assert other
    assert not torch.equal(run(name, frames, context).logits, run(name, frames, {**context, **other}).logits)


@pytest.mark.parametrize("name", POLICIES)
def test_gradients_reach_all_that_is_trained_and_nothing_else(name: str) -> None:
    trained = Factory(config_of(name)["agent"]["policy"])().train()
    frames, context = sequence(name)
    torch.manual_seed(0)
    found = trained(frames, context, trained.initial_state(2))
    (found.logits.log_softmax(-1)[..., 0].sum() + found.value.sum()).backward()
    without = {n for n, p in trained.named_parameters() if p.grad is None or not bool(p.grad.any())}
    assert without <= IDLE
    assert all(p.requires_grad for p in trained.parameters())
    backbone = getattr(trained, "_backbone", None)
    if backbone is not None:
        frozen = list(backbone._model.parameters())
        assert len(frozen) > 50
        assert not any(p.requires_grad or p.grad is not None for p in frozen)
        assert not {id(p) for p in frozen} & {id(p) for p in trained.parameters()}
        assert not backbone._model.training


@pytest.mark.parametrize("name", POLICIES)
def test_features_stand_for_their_frames(name: str) -> None:
    frames, context = sequence(name)
    features = policy(name).features(frames)
    assert torch.equal(run(name, features, context).logits, run(name, frames, context).logits)
    again = policy(name).features(features)
    assert all(torch.equal(again[key], tensor) for key, tensor in features.items())
    assert not any(tensor.requires_grad for tensor in features.values())


@pytest.mark.parametrize("name", [*POLICIES, "habit_policy"])
def test_equal_seeds_are_equal_weights(name: str) -> None:
    config = config_of(name)["agent"]["policy"]
    torch.manual_seed(5)
    first = Factory(config)().state_dict()
    torch.manual_seed(6)
    second, other = Factory(config)().state_dict(), Factory(config | {"seed": 1})().state_dict()
    assert all(torch.equal(tensor, second[key]) for key, tensor in first.items())
    assert any(not torch.equal(tensor, other[key]) for key, tensor in first.items())


@pytest.mark.parametrize("name", POLICIES)
def test_weights_in_fp16_say_nearly_the_same(name: str, tmp_path: Any) -> None:
    files = network_files(policy(name), half=True)
    for file, content in files.items():
        write_atomic(tmp_path / file, content)
    write_manifest(tmp_path, files)
    other = Factory(config_of(name)["agent"]["policy"] | {"seed": 9})().eval()
    frames, context = sequence(name)
    with torch.inference_mode():
        before = other(frames, context, other.initial_state(2)).logits
        load_network(str(tmp_path), other)
        after = other(frames, context, other.initial_state(2)).logits
    wanted = run(name, frames, context).logits
    assert (after - wanted).abs().max() < 0.02 * (before - wanted).abs().max()


@pytest.mark.parametrize("name", POLICIES)
def test_an_environment_without_images_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match=r"give env\.observe=pixels"):
        policy(name).frame({"last_action": encoded_action(7)}, {})


@pytest.mark.parametrize("name", POLICIES)
def test_a_copy_for_another_process_takes_no_frozen_network_along(name: str) -> None:
    frames, context = sequence(name)
    wanted = run(name, frames, context)
    weights = sum(t.numel() * t.element_size() for t in policy(name).state_dict().values())
    sent = pickle.dumps(policy(name))
    assert len(sent) < weights + 2e6  # tables of names are included
    copy = pickle.loads(sent)
    with torch.inference_mode():
        assert torch.equal(copy(frames, context, copy.initial_state(2)).logits, wanted.logits)


def test_augmentation_is_of_training_and_alike_for_an_episode() -> None:
    frames, _ = sequence("zson")
    still = {**frames, "rgb": frames["rgb"][:1].expand(3, -1, -1, -1, -1)}
    shown = policy("zson").augment(still, torch.Generator().manual_seed(1))
    assert shown["rgb"].dtype == torch.uint8
    assert shown["rgb"].shape == still["rgb"].shape
    assert torch.equal(shown["rgb"][0], shown["rgb"][2])
    assert not torch.equal(shown["rgb"], still["rgb"])
    assert torch.equal(shown["last_action"], frames["last_action"])
    again = policy("zson").augment(still, torch.Generator().manual_seed(1))
    assert torch.equal(again["rgb"], shown["rgb"])
    assert torch.equal(ZSON(augmented=False).augment(still, torch.Generator())["rgb"], still["rgb"])


@pytest.mark.parametrize("name", POLICIES)
def test_the_agent_says_whether_it_reads_habits(name: str) -> None:
    agent, env = built(name)
    assert agent.uses_habits is name.startswith("habit_policy")  # type: ignore[attr-defined]
    env.close()
