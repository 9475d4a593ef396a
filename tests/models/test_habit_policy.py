"""The habit policy: what its network may depend on, and that untrained it searches as ``belief`` does."""

from __future__ import annotations

import json
import shutil
import sys
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from models.agents.belief import BeliefAgent
from models.agents.checkpoint import SHIPPED as SHIPPED_WEIGHTS
from models.agents.checkpoint import UNTRAINED
from models.agents.habit_policy import HabitPolicyAgent
from models.habit_policy import HabitPolicy
from models.nets.belief.head_reader import SHIPPED, HeadReader
from models.nets.map_net import MapNet
from ucon.core.errors import ConfigError, DataError
from ucon.core.files import write_atomic, write_manifest
from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.search.twin_env import TwinSearchEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.language.encoder import one_thread
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.run.network_files import network_files
from ucon.perception.belief.from_habits import ReadHabits
from ucon.search.map_raster import CHANNELS, SIDE
from ucon.search.text_tokens import TextTokens, name_table
from ucon.search.view_tokens import RIVAL


@cache
def names() -> np.ndarray[Any, Any]:
    return name_table(TextTokens().encoder)


def some_tokens(batch: int = 3) -> dict[str, Tensor]:
    """Tokens of an early decision in each of a few episodes."""
    env, seen = UcONSearchEnv("mini", habit_level="retrieval"), []
    for number in range(batch):
        obs, _ = env.reset(options={"episode": number})
        for _ in range(3):
            obs, _, over, _, _ = env.step(0)
            assert not over
        seen.append(obs | {"thing_names": names()[obs["thing_rows"]]})
    return {
        name: torch.tensor(np.stack([obs[name] for obs in seen])).float() for name in seen[0] if name != "thing_rows"
    }


def random_policy(**options: Any) -> HabitPolicy:
    """A policy whose outputs are not just the prior."""
    torch.manual_seed(0)
    policy = HabitPolicy(**options).eval()
    with torch.no_grad():
        for parameter in policy.parameters():
            parameter.add_(0.1 * torch.randn_like(parameter))
    return policy


@torch.no_grad()
def test_the_order_of_tokens_does_not_matter() -> None:
    policy, tokens = random_policy(), some_tokens()
    before = policy(tokens)
    for kind, names in {
        "views": ("views", "prior", "action_mask"),
        "things": ("things", "thing_names", "things_mask"),
        "frontiers": ("frontiers", "frontiers_mask"),
        "habits": ("habits", "habits_relevance", "habits_mask"),
    }.items():
        order = torch.randperm(tokens[names[0]].shape[1])
        after = policy(tokens | {name: tokens[name][:, order] for name in names})
        expected = before.logits[:, order] if kind == "views" else before.logits
        torch.testing.assert_close(after.logits, expected, rtol=1e-4, atol=1e-4)
        torch.testing.assert_close(after.value, before.value, rtol=1e-4, atol=1e-4)
        foreseen = before.foresight[:, order] if kind == "views" else before.foresight
        torch.testing.assert_close(after.foresight, foreseen, rtol=1e-4, atol=1e-4)


@torch.no_grad()
def test_what_is_not_there_changes_nothing() -> None:
    policy, tokens = random_policy(), some_tokens()
    before, changed = policy(tokens), dict(tokens)
    for name, mask in (("things", "things_mask"), ("frontiers", "frontiers_mask"), ("views", "action_mask")):
        changed[name] = torch.where(tokens[mask][..., None] > 0, tokens[name], torch.tensor(7.0))
    after = policy(changed)
    torch.testing.assert_close(after.logits, before.logits, rtol=1e-4, atol=1e-4)
    assert (before.logits == float("-inf"))[tokens["action_mask"] == 0].all()


@torch.no_grad()
def test_views_far_below_the_best_are_not_chosen_unless_all_is_learned() -> None:
    policy, tokens = random_policy(), some_tokens()
    scored = policy.by_gain_over_cost(tokens) / policy.sharpness.exp()
    chosen = scored.isfinite()
    assert (chosen.sum(1) >= 1).all()
    assert (scored.amax(1, keepdim=True) - scored)[chosen].max() < RIVAL
    assert chosen.equal(policy(tokens).logits.isfinite())
    far = tokens["prior"].masked_fill(tokens["action_mask"] == 0, -torch.inf)
    assert (~chosen)[far < far.amax(1, keepdim=True) - RIVAL - 0.3].all()
    free = random_policy(use_prior=False)(tokens).logits
    assert free.isfinite().equal(tokens["action_mask"] > 0)


@torch.no_grad()
@pytest.mark.parametrize("name", ["views", "things", "thing_names", "frontiers", "habits", "ego", "target", "map"])
def test_everything_that_is_there_matters(name: str) -> None:
    policy, tokens = random_policy(), some_tokens()
    before, changed = (
        policy(tokens | {name: tokens[name] + by}).logits for by in (0.0, 100.0 if name == "map" else 0.5)
    )
    chosen = before.isfinite() & changed.isfinite()
    assert (changed - before)[chosen].abs().max() > 1e-4


@torch.no_grad()
def test_a_silent_transformer_adds_nothing_whatever_its_weights() -> None:
    loud, silent, tokens = random_policy(), HabitPolicy(silent=True).eval(), some_tokens()
    silent.load_state_dict(loud.state_dict())
    untrained = HabitPolicy().eval()
    untrained.sharpness.copy_(loud.sharpness)
    torch.testing.assert_close(silent(tokens).logits, untrained(tokens).logits, rtol=1e-5, atol=1e-5)
    assert not torch.allclose(loud(tokens).logits, untrained(tokens).logits, atol=1e-2)
    assert loud.adds
    assert not silent.adds
    assert silent.arguments == loud.arguments, "the same weights fit"
    with pytest.raises(ConfigError, match="nothing is left"):
        HabitPolicy(silent=True, use_prior=False)


@torch.no_grad()
def test_attention_for_people_is_what_the_network_attends_by() -> None:
    policy, tokens = random_policy(), some_tokens()
    seen = tokens["action_mask"] > 0
    attended = policy.attention(tokens)
    total = sum(part.sum(2) for part in attended)
    torch.testing.assert_close(total, torch.ones_like(total))
    assert (attended.habits[seen] > 0).any()
    for part, mask in ((attended.things, "things_mask"), (attended.habits, "habits_mask")):
        assert not (part * (tokens[mask][:, None] == 0)).any()
    block, x = policy.body.blocks[0], torch.randn(2, 7, policy.arguments["width"])
    bias = torch.randn(2, 4, 7, 7)
    values = block._qkv(x)[2]
    after = x + block.out((block.attention(x, bias) @ values).transpose(1, 2).reshape(x.shape))
    torch.testing.assert_close(after + block.inner(block.norm_inner(after)), block(x, bias), rtol=1e-4, atol=1e-4)


def test_its_picture_says_what_the_chosen_view_attends_to() -> None:
    agent = HabitPolicyAgent(random_policy(), UNTRAINED)
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level="gt")
    obs, info = env.reset(options={"episode": 0})
    agent.reset([info])
    assert agent._attending(0) == ""
    while not agent._searches[0].chosen:
        obs, _, _, _, info = env.step(agent.act([obs], [info])[0])
    said = agent._attending(0)
    shares = [int(word.rstrip(",%")) for word in said.split() if "%" in word]
    assert said.startswith("attends to: views ")
    assert "habits" in said
    assert 0 < sum(shares) <= 102
    shown = agent.picture(0)
    agent.policy = HabitPolicy()
    assert not agent.policy.adds
    assert agent._attending(0) == ""
    assert (shown != agent.picture(0)).any()


@torch.no_grad()
def test_what_only_a_trainer_knows_is_not_read() -> None:
    env = TwinSearchEnv("mini", habit_level="retrieval")
    obs, _ = env.reset(options={"episode": 0})
    policy = ViewPolicy(random_policy())
    told = policy.frame(obs | {"beyond": env.beyond(), "worth": np.zeros(32, np.float32)}, {})
    frames = {name: torch.as_tensor(array)[None, None] for name, array in told.items()}
    lies = {name: frames[name] + 50 for name in ("beyond", "worth")}
    true, false = policy(frames, {}, {}), policy(frames | lies, {}, {})
    assert true.logits.equal(false.logits)
    assert true.value.equal(false.value)
    assert true.foresight.equal(false.foresight)


def test_gradients_reach_all_that_is_learned() -> None:
    policy, tokens = random_policy(), some_tokens()
    scores = policy(tokens)
    (scores.logits[scores.logits.isfinite()].square().sum() + scores.value.sum()).backward()
    assert [name for name, p in policy.named_parameters() if p.grad is None or not p.grad.any()] == []


@torch.no_grad()
def test_a_mirrored_map_tells_the_same_of_mirrored_places() -> None:
    eye, image = MapNet(8).eval(), torch.rand(1, len(CHANNELS), SIDE, SIDE) * 255.0
    for layer in eye.modules():
        if isinstance(layer, torch.nn.Conv2d):
            layer.weight.copy_(layer.weight + layer.weight.flip(-1))
    xy = torch.tensor([[[0.0, 0.0], [1.3, -2.0], [-4.0, 3.1], [9.0, 0.0]]])
    mirror = xy * torch.tensor([1.0, -1.0])
    torch.testing.assert_close(eye(image, xy), eye(image.flip(-1), mirror), rtol=1e-4, atol=1e-4)


@torch.no_grad()
def test_without_the_image_of_the_map_it_is_not_read() -> None:
    policy, tokens = random_policy(raster=False), some_tokens()
    assert policy.eye is None
    assert policy(tokens | {"map": tokens["map"] + 100.0}).logits.equal(policy(tokens).logits)


def test_it_is_small() -> None:
    assert sum(p.numel() for p in HabitPolicy().parameters()) <= 5e6


@pytest.mark.timed
def test_a_decision_is_quick(capsys: pytest.CaptureFixture[str]) -> None:
    """The whole cost of a step with a choice of view: the map, places seen empty, views, tokens and the network."""
    agent, spent = HabitPolicyAgent(HabitPolicy(), SHIPPED_WEIGHTS), []
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level="retrieval")
    with one_thread():
        for number in (0, 7, 14, 21):
            obs, info = env.reset(options={"episode": number})
            agent.reset([info])
            search, over = agent._searches[0].searcher, False
            while not over:
                before, begun = search.decisions, time.process_time()
                action = agent.act([obs], [info])[0]
                if search.decisions > before:
                    spent.append(time.process_time() - begun)
                obs, _, terminated, truncated, info = env.step(action)
                over = terminated or truncated
    assert len(spent) > 20
    median, tail = 1e3 * np.percentile(spent, (50, 95))
    with capsys.disabled():
        sys.stdout.write(f"\nhabit_policy: a decision takes {median:.1f} ms, one in twenty over {tail:.1f} ms\n")
    assert median <= 30


def play(agent: Any, number: int, level: str = "retrieval") -> list[int]:
    env = UcONEnv("mini", observe="symbolic", detector=True, habit_level=level)
    obs, info = env.reset(options={"episode": number})
    agent.reset([info])
    actions, over = [], False
    while not over:
        actions.append(agent.act([obs], [info])[0])
        obs, _, terminated, truncated, info = env.step(actions[-1])
        over = terminated or truncated
    return actions


def test_untrained_it_searches_as_belief_does() -> None:
    """Very similar views are left out of the offered ones, which changes nothing in most episodes."""
    alike = [play(HabitPolicyAgent(HabitPolicy(), UNTRAINED), k) == play(BeliefAgent(), k) for k in range(6)]
    assert sum(alike) >= 4


@pytest.mark.parametrize("miss", [0.1, 1.0])
def test_what_was_found_empty_teaches_unless_it_is_told_not_to(miss: float) -> None:
    agent = HabitPolicyAgent(HabitPolicy(), UNTRAINED, miss=miss)
    env = UcONEnv("mini", observe="symbolic", detector=True)
    obs, info = env.reset(options={"episode": 0})
    agent.reset([info])
    agent.act([obs], [info])
    unseen = agent._searches[0].searcher.places.unseen
    assert len(unseen) > 0
    assert (unseen.min() < 0.5) == (miss < 1.0)


def test_a_chance_is_a_chance() -> None:
    with pytest.raises(ConfigError, match=r"agent.miss=0.0: expected a chance above 0, at most 1"):
        HabitPolicyAgent(HabitPolicy(), UNTRAINED, miss=0.0)


def test_slots_do_not_disturb_each_other() -> None:
    agent, alone = HabitPolicyAgent(random_policy(), UNTRAINED), HabitPolicyAgent(random_policy(), UNTRAINED)
    envs = [UcONEnv("mini", observe="symbolic", detector=True) for _ in range(2)]
    seen = [env.reset(options={"episode": k}) for k, env in enumerate(envs)]
    agent.reset([info for _, info in seen])
    alone.reset([seen[1][1]])
    for _ in range(40):
        actions = agent.act([obs for obs, _ in seen], [info for _, info in seen])
        assert actions[1] == alone.act([seen[1][0]], [seen[1][1]])[0]
        stepped = [env.step(action) for env, action in zip(envs, actions, strict=True)]
        if any(step[2] or step[3] for step in stepped):
            break
        seen = [(step[0], step[4]) for step in stepped]


def test_draws_are_a_function_of_seed_episode_and_decision() -> None:
    def drawn(seed: int) -> list[int]:
        return play(HabitPolicyAgent(HabitPolicy(), UNTRAINED, sample=True, seed=seed), 0)

    assert drawn(1) == drawn(1) != drawn(2)


def test_weights_are_saved_and_loaded(tmp_path: Any) -> None:
    policy = random_policy()
    files = network_files(policy)
    for name, content in files.items():
        write_atomic(tmp_path / name, content)
    write_manifest(tmp_path, files)
    agent = HabitPolicyAgent(HabitPolicy(), str(tmp_path))
    agent.check()
    assert agent.fingerprint()
    assert play(agent, 1) == play(HabitPolicyAgent(policy, UNTRAINED), 1)
    with pytest.raises(DataError, match="weights made with width=64, the agent has width=32"):
        HabitPolicyAgent(HabitPolicy(width=32), str(tmp_path)).check()


def test_another_reader_is_told_in_the_fingerprint(tmp_path: Path) -> None:
    copy = tmp_path / "head"
    shutil.copytree(SHIPPED, copy)
    shipped, same, fitted = HeadReader.load(), HeadReader.load(copy), None
    described = json.loads((copy / "config.json").read_text())
    (copy / "config.json").write_text(json.dumps(described, indent=3))
    write_manifest(copy, sorted(entry.name for entry in copy.iterdir() if entry.name != "MANIFEST.json"))
    other = HeadReader.load(copy)

    def told(reader: HeadReader | None) -> str | None:
        return HabitPolicyAgent(HabitPolicy(), UNTRAINED, locate=ReadHabits(reader)).fingerprint()

    assert told(shipped) == told(same) != told(other)
    assert told(fitted) == ""


def test_without_weights_it_says_how_to_get_them() -> None:
    with pytest.raises(ConfigError, match=r"no trained weights; train it with `python train.py agent=habit_policy`"):
        HabitPolicyAgent(HabitPolicy()).check()
