"""PPO with both kinds of policies: it learns, can be stopped anywhere, and refuses senseless options."""

import functools
import json

import pytest
import torch
from tensordict import TensorDict

from models.agents.habit_policy import HabitPolicyAgent
from tests.learning.test_imitation import Broken, files
from tests.learning.tiny_policy import Counting, Stays, TinyPolicy, on_a_gpu
from tests.learning.tiny_ppo import narrow_habit_policy, tiny_ppo
from ucon.core.errors import ConfigError, DataError, DivergedError
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.policies.view_policy import ViewPolicy
from ucon.learning.ppo.checks import collection_size
from ucon.learning.ppo.clipped_loss import PPOLoss
from ucon.learning.ppo.collecting import InWorkers
from ucon.learning.run.stopping import Stopping
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun
from ucon.task.reward import Reward


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("episodes")


@pytest.fixture
def learner(folder):
    return functools.partial(tiny_ppo, folder)


def test_it_learns_what_pays(learner):
    """If every step costs one point and only Done ends that, it soon says Done at once."""
    dear = functools.partial(UcONEnv, "mini", observe="pixels", reward=Reward(success=0.0, step=-1.0))
    found = learner(env=dear, frames=120, minibatch=40, lr=2e-2, epochs=4, kl_stop=1.0, levels=("none",))
    figures = [found.step() for _ in range(8)]
    assert figures[0]["steps"] > 4
    assert figures[-1]["steps"] < 2
    assert figures[-1]["return"] > 0.6 * figures[0]["return"]
    assert figures[-1]["entropy"] < figures[0]["entropy"]
    assert figures[-1]["value_loss"] < 0.3 * figures[0]["value_loss"]


def test_the_longest_list_it_may_learn_from_is_kept_with_the_policy(learner):
    class Reading(TinyPolicy):
        max_habits = 1024

    short = functools.partial(UcONEnv, "mini", observe="pixels", max_habits=700)
    assert learner(Reading(), env=short).network.max_habits == 700
    assert learner(env=short).network.max_habits is None


def test_the_loss_is_the_clipped_objective():
    draw = torch.Generator().manual_seed(0)
    logits = torch.randn(50, 5, generator=draw)
    logits[:, 4] = -torch.inf  # not offered
    action = torch.randint(0, 4, (50,), generator=draw)
    now = logits.log_softmax(-1).gather(1, action[:, None])[:, 0]
    before = now + 0.4 * torch.randn(50, generator=draw)
    advantage, target, value = torch.randn(3, 50, generator=draw)
    played = {"action": action, "action_log_prob": before, "advantage": advantage[:, None]}
    logits.requires_grad_()
    batch = TensorDict({**played, "value_target": target[:, None]}, [50])
    loss, figures = PPOLoss(clip=0.2, entropy=0.01, value=0.5)(batch, logits, value)
    ratio = (now - before).exp()
    gain = torch.minimum(ratio * advantage, ratio.clamp(0.8, 1.2) * advantage).mean()
    p = logits.detach()[:, :4].softmax(-1)
    entropy = -(p * p.log()).sum(-1).mean()
    expected = -gain + 0.5 * ((value - target) ** 2).mean() - 0.01 * entropy
    assert float(loss.detach()) == pytest.approx(float(expected), abs=1e-5)
    assert figures["entropy"] == pytest.approx(float(entropy), abs=1e-5)
    assert figures["kl"] == pytest.approx(float((ratio - 1 - ratio.log()).mean()), abs=1e-5)
    assert 0.2 < figures["clipped"] < 0.9
    loss.backward()
    assert bool(torch.isfinite(logits.grad).all())
    assert bool((logits.grad[:, 4] == 0).all())


@pytest.mark.parametrize("kind", ["actions", "views"])
def test_a_run_that_is_killed_goes_on_to_the_same_bytes(learner, tmp_path, kind):
    """This includes the moving average, the falling learning rate and the order of episodes."""

    def made():
        policy = TinyPolicy(dropout=0.2) if kind == "actions" else narrow_habit_policy()
        return learner(policy, frames=30, steps=4, average=0.9, anneal=True)

    class KilledError(Exception):
        pass

    def kill(step, figures):
        if step == 3 and "loss" in figures:
            raise KilledError

    plan = Plan(steps=4, validate_every=2, save_every=1, keep=2)
    whole = TrainingRun(tmp_path / "whole", made(), plan, {})
    whole.start("a: 1\n")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", made(), plan, {})
    parts.start("a: 1\n")
    with pytest.raises(KilledError):
        parts.run(kill)
    again = TrainingRun(tmp_path / "parts", made(), plan, {})
    again.resume()
    assert again.step == 2
    again.run()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")
    lines = [json.loads(line) for line in (tmp_path / "whole" / METRICS).read_text().splitlines()]
    assert [line["frames"] for line in lines if "frames" in line] == [30, 60, 90, 120]
    if kind == "views":
        agent = HabitPolicyAgent(narrow_habit_policy(seed=1), str(tmp_path / "whole"))
        agent.check()
        with whole.learner.updates.averaged():
            best = {name: value.clone() for name, value in whole.learner.network.state_dict().items()}
        assert all(torch.equal(value, best[name]) for name, value in agent.policy.state_dict().items())


@pytest.mark.slow
def test_workers_remember_nothing(learner):
    """Collecting again, after workers have played on, gives the same steps; the rows differ from each other."""
    found = learner(collector=InWorkers(2), frames=40)
    found.step()
    state = found.state_dict()
    kept = type(state)({k: v.clone() for k, v in state.tensors.items()}, dict(state.values))
    first = [found.step() for _ in range(2)]
    ends = {k: v.clone() for k, v in found.state_dict().tensors.items()}
    found.load_state_dict(kept)
    assert [found.step() for _ in range(2)] == first
    assert all(torch.equal(ends[name], value) for name, value in found.state_dict().tensors.items())
    batch = found.rollouts.collect(5)
    assert batch.shape == (2, 21)
    assert not torch.equal(batch["frames", "depth"][0], batch["frames", "depth"][1])
    found.rollouts.close()


@pytest.mark.slow
def test_workers_of_a_run_that_goes_on_give_the_same_bytes(learner, tmp_path):
    def made():
        return learner(collector=InWorkers(2), frames=40, steps=4)

    plan = Plan(steps=4, validate_every=4, save_every=1)
    runs = [TrainingRun(tmp_path / name, made(), plan, {}) for name in ("whole", "parts")]
    for run in runs:
        run.start("")
    runs[0].run()
    runs[1]._begin(Stopping(print), lambda step, figures: None)
    for _ in range(2):
        runs[1]._one_step(Stopping(print), lambda step, figures: None)
    again = TrainingRun(tmp_path / "parts", made(), plan, {})
    again.resume()
    again.run()
    for run in (*runs, again):
        run.learner.rollouts.close()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


def test_validating_changes_nothing(learner):
    plain, watched = (learner(frames=30, average=0.5) for _ in range(2))
    assert watched.validate() == watched.validate()
    first = plain.step()
    assert first == watched.step()
    found = watched.validate()
    assert found["score"] == found["spl"]
    assert plain.step() == watched.step()
    assert first["frames"] == 30


def test_passes_end_where_the_policy_has_moved_far(learner):
    near, far = (learner(epochs=5, kl_stop=stop, lr=2e-2).step() for stop in (1e-9, 1e6))
    assert far["passes"] == 5
    assert near["passes"] < 5


def test_statistics_are_told_of_every_frame_and_of_no_padding(learner):
    found = learner(Counting(), frames=50)
    assert [found.step()["frames"] for _ in range(2)][-1] == found.policy.n_seen > 0


def test_the_average_counts_updates(learner):
    """Two collections make many updates, so different decays give different averages."""
    few, many = (learner(narrow_habit_policy(), frames=60, minibatch=4, average=decay) for decay in (0.6, 0.9))
    for found in (few, many):
        for _ in range(2):
            found.step()
        assert found.updates.taken > 20
    values = [found.updates.tensors()["average/network.score.0.weight"] for found in (few, many)]
    assert not torch.equal(*values)
    own = many.updates.tensors()["learned/network.score.0.weight"]
    assert float((values[0] - own).norm()) < float((values[1] - own).norm())


def test_a_memory_that_no_machine_holds_is_refused_before_playing(learner):
    from models.habit_policy_e2e import HabitPolicyE2E

    with pytest.raises(
        ConfigError, match=r"learner.frames=9000: the memory of habit_policy_e2e .* give learner.frames="
    ):
        learner(HabitPolicyE2E(), frames=9000)


def test_collections_are_as_large_as_the_memory_of_the_policy_leaves_room_for():
    from models.habit_policy_e2e import HabitPolicyE2E

    assert collection_size(HabitPolicyE2E(), "auto") == 1000
    assert collection_size(HabitPolicyE2E(), 4000) == 4000
    assert collection_size(TinyPolicy(), "auto") == 9000
    assert collection_size(ViewPolicy(narrow_habit_policy()), "auto") == 9000
    with pytest.raises(ConfigError, match=r"learner\.frames=all: must be above 0 and whole"):
        collection_size(TinyPolicy(), "all")


@pytest.mark.parametrize("policy", [TinyPolicy, narrow_habit_policy])
def test_a_loss_without_the_objective_is_refused(learner, policy):
    with pytest.raises(ConfigError, match=r"learner\.loss\.objective=0: \w+ would not learn what to choose"):
        learner(policy(), loss=PPOLoss(objective=0))


def test_a_gpu_is_used_in_half_the_bits(learner, monkeypatch):
    on_a_gpu(monkeypatch)
    found = learner(Stays(), device="auto", precision="auto")
    assert found.resolved_options == {"device": "cuda", "precision": "bfloat16"}
    assert found.options.minibatch == learner().options.minibatch
    assert learner(precision="auto").resolved_options == {"device": "cpu", "precision": "float32"}


def test_equal_seeds_are_equal_runs(learner):
    first, second, other = (narrow_habit_policy(seed) for seed in (0, 0, 1))
    runs = [learner(policy, frames=30).step() for policy in (first, second, other)]
    assert runs[0] == runs[1] != runs[2]


def test_bfloat16_is_close(learner):
    exact, rough = (learner(narrow_habit_policy(), frames=25, precision=p).step() for p in ("float32", "bfloat16"))
    assert exact["loss"] != rough["loss"]
    assert exact["loss"] == pytest.approx(rough["loss"], abs=0.1)


@pytest.mark.parametrize("where", ["value", "logits", "gradient of worth.weight"])
def test_numbers_that_are_none_stop_it_and_are_named(learner, where):
    policy = Broken("")
    found = learner(policy)
    policy.where = where
    if where.startswith("gradient"):
        policy.worth.weight.register_hook(lambda gradient: gradient / 0)
    before = policy.choose.weight.clone()
    with pytest.raises(DivergedError) as caught:
        found.step()
    assert str(caught.value).startswith(f"step 1: {where}")
    assert "\n" not in str(caught.value)
    assert torch.equal(policy.choose.weight, before)


def test_a_state_of_another_network_is_refused(learner):
    state = learner(TinyPolicy(width=16)).state_dict()
    with pytest.raises(DataError, match="state of another learner"):
        learner().load_state_dict(state)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"policy": 3}, "no policy that can be trained"),
        ({"frames": 0}, r"learner\.frames=0: must be above 0"),
        ({"epochs": 1.5}, r"learner\.epochs=1\.5: must be above 0 and whole"),
        ({"trace": 1.1}, r"learner\.trace=1\.1: must be from 0 to 1"),
        ({"precision": "float8"}, "unknown precision 'float8'"),
        ({"device": "cuda:7"}, r"learner\.device=cuda:7: torch sees no such GPU"),
        ({"device": "mps"}, r"learner\.device=mps: expected cpu, cuda, cuda:NUMBER or auto"),
        ({"device": "meta"}, r"learner\.device=meta: expected cpu, cuda, cuda:NUMBER or auto"),
        ({"levels": []}, r"learner\.levels=.*: expected a list"),
        ({"levels": ["ful"]}, "unknown habit level 'ful'"),
        ({"n_episodes": 0}, r"learner\.n_episodes=0: expected a whole number from 1 to 6"),
        ({"episodes": "mini"}, r"of the (val|test) part, which is not for training"),
        ({"validation": {"episodes": "test"}}, r"of the test part, which must not choose checkpoints"),
        ({"validation": {"choose": "loss"}}, r"learner\.validation\.choose=loss: expected success_rate or spl"),
        ({"policy": narrow_habit_policy(), "search": UcONEnv}, "expected the environment UcONSearch"),
    ],
)
def test_options_that_make_no_sense(learner, options, message):
    with pytest.raises(ConfigError, match=message) as caught:
        learner(**options).step()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["clip", "entropy", "value"])
def test_weights_that_make_no_sense(name):
    with pytest.raises(ConfigError, match=rf"learner\.loss\.{name}=-1: must be a number from"):
        PPOLoss(**{name: -1})
