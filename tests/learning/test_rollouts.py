"""Experience is what the policy did: its memory is carried along, ends with the episode, and is used in learning."""

import functools

import pytest
import torch
from tensordict import TensorDict
from torchrl.envs import InitTracker, TransformedEnv
from torchrl.envs.utils import check_env_specs

from tests.learning.tiny_policy import ENV, TinyPolicy, training_file
from tests.learning.tiny_ppo import LEVELS, SEARCH, narrow_habit_policy
from ucon.core.errors import ConfigError, DataError
from ucon.core.rng import stream
from ucon.learning.policies.actor import rollout_actor
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.ppo.collecting import ExperienceCollector, InProcess, InWorkers
from ucon.learning.ppo.experience import Experience
from ucon.learning.ppo.rollout_env import STATE, PolicyEnv, rollout_env
from ucon.task.sets import load_episodes

MEMORY = ("hidden", "cell")


@pytest.fixture(scope="module")
def episodes(tmp_path_factory):
    return load_episodes(training_file(tmp_path_factory.mktemp("episodes")))


def rollouts(policy, episodes, steps, env=ENV, levels=LEVELS):
    return ExperienceCollector(policy, env, episodes, levels, InProcess(), steps)


@pytest.fixture(scope="module")
def played(episodes):
    """A policy, and sixty of its steps in several short episodes (it often says Done)."""
    policy = TinyPolicy()
    policy.choose.bias.data[6] += 1.0
    batch = rollouts(policy, episodes, 60).collect(3)
    assert 4 <= int(batch["is_init"].sum()) < 30
    return policy, batch


def remembered(policy, batch):
    """Whether every step of (1, T) was played with exactly the memory of the steps before it in its episode."""
    state = policy.initial_state(1)
    for t in range(batch.shape[1]):
        step = batch[:, t]
        if bool(step["is_init"]):
            state = policy.initial_state(1)
        if not all(torch.equal(step[STATE, name], state[name]) for name in MEMORY):
            return False
        frames = {name: tensor[None] for name, tensor in step["frames"].items()}
        with torch.no_grad():
            out = policy(frames, dict(step["context"].items()), state)
        if not torch.allclose(out.logits[0], step["logits"], atol=1e-6):
            return False
        state = out.state
    return True


def test_memory_is_carried_and_ends_with_its_episode(played):
    policy, batch = played
    assert remembered(policy, batch)
    after = ~batch["is_init"][0, :, 0]
    assert bool((batch[STATE, "hidden"][0, after].abs().sum((1, 2)) > 0).all())
    over = torch.cat([torch.ones(1, dtype=bool), batch["next", "done"][0, :-1, 0]])
    assert torch.equal(over, ~after)


@pytest.mark.parametrize("fault", ["dropped", "leaking"])
def test_memory_that_is_lost_or_leaks_would_be_found(played, episodes, fault):
    policy, _ = played
    made = rollouts(policy, episodes, 40)
    if fault == "dropped":
        made._actor[0].names = ()  # it reads no state and writes none
        policy_state = policy.initial_state(1)
        made._playing.forward = functools.partial(_forgetful, made._playing, policy_state)
    else:
        made._make = functools.partial(_leaking, made._make)
    assert not remembered(policy, made.collect(3))


def _forgetful(policy, state, frames, context, given):
    return TinyPolicy.forward(policy, frames, context, state)


def _leaking(make):
    """A maker of environments in which the memory is not reset at later episodes."""
    env = make()
    primer = env.transform[1]
    fresh, count = primer.default_value, []

    def stale(reset=None):
        count.append(1)
        return fresh() if len(count) < 3 else fresh().apply(lambda t: t + 1)

    primer.default_value = stale
    return env


def test_a_primer_that_is_left_out_is_noticed_at_once(played, episodes):
    policy, _ = played
    bare = TransformedEnv(PolicyEnv(policy, ENV(), episodes, LEVELS), InitTracker())
    with pytest.raises(DataError, match=r"no recurrent state 'hidden'.*TensorDictPrimer"):
        bare.rollout(3, rollout_actor(policy))


@pytest.mark.parametrize("chunk", [1, 7, 100])
def test_what_is_learned_from_is_what_was_played(played, chunk):
    """Read again in sequences, the policy gives the same probabilities, so no memory was lost or leaked."""
    policy, batch = played
    experience = Experience(batch, 0.9, 0.8, chunk)
    seen = 0
    for part in experience.minibatches(16, stream(0, "test")):
        with torch.no_grad():
            out = policy(part.frames, part.context, part.state)
        log_prob = out.logits[part.there].log_softmax(-1)
        chosen = log_prob.gather(1, part.played["action"][:, None])[:, 0]
        assert torch.allclose(chosen, part.played["action_log_prob"], atol=1e-5)
        assert part.there.shape[0] <= chunk
        seen += len(chosen)
    assert seen == len(experience) == batch.shape[1] - 1


def test_advantages_end_with_episodes_and_the_rest_is_foreseen():
    draw = torch.Generator().manual_seed(0)
    rows, steps, discount, trace = 2, 12, 0.9, 0.8
    value, reward = torch.randn(2, rows, steps, 1, generator=draw)
    done = torch.rand(rows, steps, 1, generator=draw) < 0.25
    init = torch.cat([torch.ones(rows, 1, 1, dtype=bool), done[:, :-1]], 1)
    ends = {"reward": reward, "done": done, "terminated": done, "outcome": torch.zeros(rows, steps, 3)}
    batch = TensorDict({"state_value": value, "is_init": init, "next": ends}, [rows, steps])
    found = Experience(batch, discount, trace, 4)
    expected = torch.zeros(rows, steps - 1, 1)
    for row in range(rows):
        later = 0.0
        for t in reversed(range(steps - 1)):
            on = 0.0 if done[row, t] else 1.0
            error = reward[row, t] + discount * on * value[row, t + 1] - value[row, t]
            later = error + discount * trace * on * later
            expected[row, t] = later
    assert done[:, :-1].any()
    assert torch.allclose(found.target, expected + value[:, :-1], atol=1e-5)
    assert torch.allclose(found.advantage, (expected - expected.mean()) / expected.std(), atol=1e-4)
    for row, first, length in found.sequences:
        assert length <= 4
        assert not init[row, first + 1 : first + length].any()
    assert found.sequences[:, 2].sum() == rows * (steps - 1)


def test_experience_is_a_function_of_weights_and_seed(played, episodes):
    policy, batch = played
    made = rollouts(policy, episodes, 60)
    other, again = made.collect(4).clone(), made.collect(3)
    assert all(torch.equal(batch[key], again[key]) for key in batch.keys(True, True) if "traj_ids" not in key)
    assert not torch.equal(other["frames", "depth"], again["frames", "depth"])
    levels = sorted({float(x) for x in batch["context", "habits"].flatten()})
    assert levels == pytest.approx([0.0, 0.2]), "both levels are in every collection"


@pytest.mark.parametrize("kind", ["actions", "views"])
def test_torchrl_accepts_the_environment(kind, episodes):
    policy, make = (TinyPolicy(), ENV) if kind == "actions" else (ViewPolicy(narrow_habit_policy()), SEARCH)
    check_env_specs(rollout_env(policy, make, episodes, LEVELS), seed=0)


def test_views_that_are_not_offered_are_never_chosen(episodes):
    policy = ViewPolicy(narrow_habit_policy(use_prior=False))  # all offered views are about equally likely
    batch = rollouts(policy, episodes, 40, SEARCH).collect(0)
    offered = batch["frames", "action_mask"]
    assert bool(offered.gather(2, batch["action"][..., None]).bool().all())
    assert len(set(batch["action"].flatten().tolist())) > 10
    assert int(offered.sum(-1).min()) < offered.shape[-1]


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2", True])
def test_no_workers_are_refused(workers):
    with pytest.raises(ConfigError, match=r"collector\.workers=.*expected a whole number from 1"):
        InWorkers(workers)
