"""The agent that plays any policy: separate states for slots, and the same random draws for the same step."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import nn

from models.agents.policy import PolicyAgent
from models.nets.policy_defaults import N_ACTIONS, PolicyModule, lstm_state, run_lstm
from tests.models.playing import POLICIES, built, config_of, episodes, gone, play
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError, DataError, UconError
from ucon.core.files import write_atomic, write_manifest
from ucon.learning.policies.action_policy import Arrays, PolicyOutputs, Tensors
from ucon.learning.run.network_files import WEIGHTS, network_files

ROOT = Path(__file__).parents[2]


class Remembering(PolicyModule):
    """An LSTM over a number, whose outputs depend on everything it was ever shown."""

    architecture = "remembering"

    def __init__(self, seed: int = 0) -> None:
        super().__init__()
        torch.manual_seed(seed)
        self.lstm, self.head = nn.LSTM(2, 16), nn.Linear(16, N_ACTIONS)
        self.batches: list[int] = []
        for weights in self.parameters():
            nn.init.normal_(weights)
        nn.init.constant_(self.lstm.bias_ih_l0[16:32].data, 2.0)  # so that it forgets little

    def context(self, info: Mapping[str, Any]) -> Arrays:
        return {"wanted": np.array([info["wanted"]], np.float32)}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        return {"seen": np.array([observation["seen"]], np.float32)}

    def initial_state(self, batch: int) -> Tensors:
        return lstm_state(batch, self.lstm)

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        self.batches.append(frames["seen"].shape[1])
        wanted = context["wanted"].expand(*frames["seen"].shape[:2], 1)
        hidden, state = run_lstm(self.lstm, torch.cat([frames["seen"], wanted], -1), state)
        return PolicyOutputs(self.head(hidden), hidden[..., 0], state)


def remembering(**options: Any) -> PolicyAgent:
    return PolicyAgent(Remembering(), "untrained", **options)


def info(number: int) -> dict[str, Any]:
    return {"episode": f"e{number}", "wanted": number / 2}


def seen(number: int, steps: int = 20) -> list[dict[str, float]]:
    values = np.random.default_rng(number).normal(size=steps) * 3
    return [{"seen": float(value)} for value in values]


def alone(agent: PolicyAgent, number: int, slot: int = 0) -> list[int]:
    agent.reset([info(number)], [slot])
    return [agent.act([obs], [info(number)], [slot])[0] for obs in seen(number)]


@pytest.mark.parametrize("sample", [False, True])
def test_an_episode_is_the_same_alone_and_among_others(sample: bool) -> None:
    """Slots in any order, and episodes that begin and end while others continue."""
    agent = remembering(sample=sample)
    wanted = [alone(remembering(sample=sample), number) for number in range(4)]
    assert len({tuple(actions) for actions in wanted}) == 4
    found: list[list[int]] = [[] for _ in wanted]
    slots, begin = {0: 5, 1: 2, 2: 9, 3: 2}, {0: 0, 1: 0, 2: 4, 3: 20}  # the last one takes over a slot
    for step in range(40):
        starting = [n for n in slots if begin[n] == step]
        agent.reset([info(n) for n in starting], [slots[n] for n in starting])
        playing = [n for n in reversed(slots) if 0 <= step - begin[n] < 20]
        observed = [seen(n)[step - begin[n]] for n in playing]
        actions = agent.act(observed, [info(n) for n in playing], [slots[n] for n in playing])
        for n, action in zip(playing, actions, strict=True):
            found[n].append(action)
    assert found == wanted
    assert max(agent.policy.batches) == 3  # together in one forward pass


def test_a_reset_forgets_and_nothing_else_does() -> None:
    """It would act differently with the state of another episode, or with none."""
    agent = remembering()
    wanted = alone(agent, 1)
    assert alone(agent, 1) == wanted  # played before in this slot
    agent.reset([info(1)])
    forgetful = []
    for obs in seen(1):
        agent.reset([info(1)])
        forgetful += agent.act([obs], [info(1)])
    assert forgetful != wanted
    alone(agent, 2)
    agent._episodes[0].context = {"wanted": torch.tensor([0.5])}
    leaked = [agent.act([obs], [info(1)])[0] for obs in seen(1)]
    assert leaked != wanted


def test_draws_are_a_function_of_seed_episode_and_step() -> None:
    first = [alone(remembering(sample=True, seed=seed), 1) for seed in (0, 0, 1)]
    assert first[0] == first[1] != first[2]
    busy = remembering(sample=True)
    alone(busy, 2)
    assert alone(busy, 1, slot=3) == first[0]
    assert alone(remembering(), 1) != first[0]
    undecided = remembering(sample=True)
    nn.init.zeros_(undecided.policy.head.weight)  # type: ignore[arg-type]
    nn.init.zeros_(undecided.policy.head.bias)  # type: ignore[arg-type]
    assert len(set(alone(undecided, 1))) > 3  # every step has its own draw


def test_draws_follow_the_probabilities() -> None:
    agent = remembering(sample=True, temperature=1.0)
    agent.reset([info(1)])
    with torch.inference_mode():
        outputs = agent.policy(
            {"seen": torch.tensor([[[0.5]]])}, {"wanted": torch.tensor([[1.0]])}, agent.policy.initial_state(1)
        )
    chances = outputs.logits[0, 0].softmax(-1).numpy()
    counts = np.zeros(N_ACTIONS)
    for number in range(600):
        told = {"episode": f"another {number}", "wanted": 1.0}
        agent.reset([told])
        counts[agent.act([{"seen": 0.5}], [told])[0]] += 1
    assert np.abs(counts / 600 - chances).max() < 0.08


def saved(folder: Path, policy: PolicyModule) -> Path:
    files = network_files(policy)
    for name, content in files.items():
        write_atomic(folder / name, content)
    write_manifest(folder, files)
    return folder


def test_a_checkpoint_is_played(tmp_path: Path) -> None:
    folder = saved(tmp_path / "run" / "model", Remembering(seed=1))
    trained = PolicyAgent(Remembering(), str(folder.parent))
    trained.check()
    assert alone(trained, 1) == alone(PolicyAgent(Remembering(seed=1), "untrained"), 1) != alone(remembering(), 1)
    assert (trained.name, remembering().name) == ("remembering", "remembering (untrained)")
    print_of = trained.fingerprint()
    assert print_of is not None
    assert len(print_of) == 64
    (folder / WEIGHTS).write_bytes(b"other")
    assert PolicyAgent(Remembering(), str(folder)).fingerprint() not in (None, print_of)
    with pytest.raises(DataError, match="truncated or altered"):
        PolicyAgent(Remembering(), str(folder)).check()


class Reading(Remembering):
    """A policy that is given habits."""

    uses_habits = True
    max_habits = 1024


def test_a_list_longer_than_it_learned_from_is_refused(tmp_path: Path) -> None:
    policy = Reading()
    policy.max_habits = 3
    agent = PolicyAgent(Reading(), str(saved(tmp_path, policy)))
    agent.reset([info(0) | {"habits": ("a", "b", "c")}])
    told = (
        r"episode e0: 4 habits, but remembering was trained with at most 3; "
        r"give habit_level=retrieval .* env\.max_habits=4"
    )
    with pytest.raises(ConfigError, match=told):
        agent.reset([info(0) | {"habits": ("a", "b", "c", "d")}])


def test_the_shipped_policy_refuses_what_no_training_gave() -> None:
    config = config_of("habit_policy_e2e", "habit_level=full", "env.max_habits=3000")
    agent, env = Factory(config["agent"])(), Factory(config["env"])()
    _, told = env.reset(options={"episode": 0})
    agent.reset([told])
    longer = told | {"habits": (told["habits"] * 4)[:1025]}
    with pytest.raises(ConfigError, match="1025 habits, but habit_policy_e2e was trained with at most 1024"):
        agent.reset([longer])


def test_weights_that_became_no_numbers_are_told() -> None:
    policy = Remembering()
    with torch.no_grad():
        policy.head.bias[0] = torch.nan
    agent = PolicyAgent(policy, "untrained")
    agent.reset([info(1)])
    with pytest.raises(DataError, match="logits are not finite at step 0"):
        agent.act([seen(1)[0]], [info(1)])


@pytest.mark.parametrize("name", POLICIES)
def test_without_weights_it_says_how_to_train_them(name: str, tmp_path: Path) -> None:
    config = config_of(name)["agent"]
    for checkpoint in (None, str(tmp_path)):
        agent = Factory(config | {"checkpoint": checkpoint})()
        assert agent.fingerprint() is None
        for use in (agent.check, lambda made=agent: made.reset([{}])):
            with pytest.raises(UconError, match=f"train.py agent={name}`") as caught:
                use()
            assert "\n" not in str(caught.value)


def test_a_gpu_where_there_is_none_is_one_line() -> None:
    if torch.cuda.is_available():
        pytest.skip("there is one")
    with pytest.raises(ConfigError, match=r"agent\.device=cuda: torch sees no such GPU here; give agent\.device=cpu"):
        remembering(device="cuda").check()
    with pytest.raises(ConfigError, match=r"agent\.device=gpu: expected cpu, cuda, cuda:NUMBER or auto"):
        remembering(device="gpu").reset([info(1)])
    remembering(device="auto").check()


def untrained(name: str) -> tuple[PolicyAgent, Any]:
    """The configured network with random weights; it samples its actions, so that they vary."""
    config = config_of(name)["agent"] | {"checkpoint": "untrained", "sample": True}
    return Factory(config)(), built(name)[1]


@pytest.mark.parametrize("name", POLICIES)
def test_networks_play_a_batch_as_its_parts_and_see_no_secrets(name: str) -> None:
    agent, env = untrained(name)
    first, second = episodes(2)
    alone = [play(agent, env, episode, 6) for episode in (first, second)]
    unseen = play(agent, env, first, 6, unseen=True)
    assert play(agent, env, gone(first), len(unseen)) == unseen == alone[0][: len(unseen)]
    envs = [env, untrained(name)[1]]
    frames = [e.reset(options={"episode": episode}) for e, episode in zip(envs, (first, second), strict=True)]
    agent.reset([frames[1][1]], slots=[7])
    agent.reset([frames[0][1]], slots=[3])
    together: list[list[int]] = [[], []]
    for _ in range(min(map(len, alone))):
        chosen = agent.act([f[0] for f in frames], [f[1] for f in frames], slots=[3, 7])
        for k, action in enumerate(chosen):
            together[k].append(action)
            obs, _, _, _, told = envs[k].step(action)
            frames[k] = obs, told
    assert together == [actions[: len(together[0])] for actions in alone]


def evaluated(*overrides: str) -> subprocess.CompletedProcess[str]:
    quick = ("episodes=mini", "limit=1", "pictures=0", "progress=false", "workers=0")
    command = [sys.executable, "eval.py", *overrides, *quick]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)


def test_evaluation_plays_a_checkpoint_and_names_a_missing_one(tmp_path: Path) -> None:
    missing = evaluated("agent=zson", f"out={tmp_path}/missing")
    assert missing.returncode == 2
    last = missing.stderr.strip().splitlines()[-1]
    assert "train it with `python train.py agent=zson`" in last
    folder = saved(tmp_path / "run" / "model", Factory(config_of("zson")["agent"]["policy"])())
    done = evaluated("experiment=table1_zson", f"agent.checkpoint={folder.parent}", f"out={tmp_path}/out")
    assert done.returncode == 0, done.stderr[-2000:]
    assert '"uses_habits": false' in (tmp_path / "out" / "summary.json").read_text()
