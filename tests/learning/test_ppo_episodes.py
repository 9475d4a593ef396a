"""PPO on whole episodes: what is collected, how it is learned from, and that it can be stopped anywhere."""

import dataclasses
import functools
from contextlib import closing

import numpy as np
import pytest
import torch
from torchrl.objectives.value.functional import generalized_advantage_estimate

from tests.learning.test_imitation import files
from tests.learning.tiny_policy import Stays, TinyPolicy, on_a_gpu, tiny_ppo_episodes
from ucon.core.errors import ConfigError, DataError
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.episodes.collecting import EpisodeRollouts
from ucon.learning.episodes.experience import compared, experience_from_json, generalised_advantages
from ucon.learning.imitation.feeding import _unpacked
from ucon.learning.imitation.replaying import Replayer
from ucon.learning.run.training_run import Plan, TrainingRun
from ucon.task.actions import Action
from ucon.task.reward import Reward


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("episodes")


def lasting():
    """A policy that seldom says Done by chance."""
    policy = TinyPolicy()
    with torch.no_grad():
        policy.choose.bias[Action.DONE] -= 5
    return policy


@pytest.fixture
def learner(folder):
    return functools.partial(tiny_ppo_episodes, folder)


def test_advantages_are_those_of_torchrl():
    draw = np.random.default_rng(0)
    rewards, values = (draw.normal(size=30).astype(np.float32) for _ in range(2))
    over = torch.zeros(30, 1, dtype=torch.bool)
    over[-1] = True
    value, reward = torch.from_numpy(values)[:, None], torch.from_numpy(rewards)[:, None]
    after = torch.cat([value[1:], torch.zeros(1, 1)])
    wanted, _ = generalized_advantage_estimate(0.97, 0.9, value, after, reward, over, over)
    assert np.allclose(generalised_advantages(rewards, values, 0.97, 0.9), wanted[:, 0].numpy(), atol=1e-5)


def test_a_collection_is_played_on_the_device_of_one_s_choice(learner, monkeypatch):
    on_a_gpu(monkeypatch)
    found = learner(Stays(), play_device="auto")
    found.step()
    assert found.feeder._collector._policy.sent == found.resolved_options["play_device"] == "cuda"
    assert found.policy.sent == "cpu"


def test_what_is_remembered_of_a_collection_is_what_the_policy_that_played_thinks_of_it(learner):
    """Played three at once and read one by one, the probabilities are the same, so ratios start at 1."""
    found, raws = learner(lasting(), lr=1e-9), []
    figures = found.step()
    assert figures["kl"] < 1e-6
    assert figures["clipped"] == 0
    assert figures["steps"] == np.mean([len(one.actions) for one in found.collected])
    for one, replay in found.feeder([found.collected]).__next__():
        frames = {name: torch.from_numpy(array)[:, None] for name, array in replay.frames.items()}
        context = {name: torch.from_numpy(array)[None] for name, array in replay.context.items()}
        with torch.no_grad():
            outputs = found.act(frames, context, found.act.initial_state(1))
        log_p = (outputs.logits[:, 0] / found.rollouts.temperature).log_softmax(-1)
        assert np.allclose(log_p.gather(1, torch.from_numpy(one.classes)[:, None])[:, 0], one.log_p, atol=1e-3)
        raws.append(generalised_advantages(replay.rewards, outputs.value[:, 0].numpy(), 0.99, 0.95))
        assert np.allclose(one.target, raws[-1] + outputs.value[:, 0].numpy(), atol=1e-3)
    raw, given = np.concatenate(raws), np.concatenate([one.advantage for one in found.collected])
    assert np.allclose((raw - raw.mean()) / raw.std(), given, atol=0.02)


def test_every_epoch_reads_each_episode_of_the_newest_collection_once(learner):
    found = learner(rollouts={"epochs": 2})
    found.step()
    assert found.per_iteration == 4
    before = found.collected
    found.done = 0
    batches = list(found.batches())
    for epoch in (batches[:2], batches[2:]):
        assert sorted(id(one) for batch in epoch for one in batch) == sorted(map(id, before))
    found.done = 1
    for _ in range(4):
        found.step()
    assert len(found.collected) == 4
    assert not set(map(id, found.collected)) & set(map(id, before))
    assert len(found.feeder._kept) == 4


@pytest.mark.parametrize("by", ["spl", "return"])
def test_repetitions_of_an_episode_are_compared_with_each_other(learner, by):
    found = learner(lasting(), rollouts={"episodes": 6, "repeats": 3, "compare": by})
    assert [found.job(item) for item in range(6)] == [found.job(0)] * 3 + [found.job(3)] * 3
    found._playing = found.weights_that_play()
    made = [one for collected in found._asked_for(0) for one in collected()]
    assert [(one.episode.id, one.level) for one in made] == [
        (job.episode.id, job.level) for job in map(found.job, range(6))
    ]
    assert len({one.actions for one in made[:3]}) > 1, "they are played by other draws"
    came = [one.spl if by == "spl" else one.gained for one in made]
    for at, one in enumerate(compared(made, 3, by)):
        group = range(at - at % 3, at - at % 3 + 3)
        others = np.mean([came[k] for k in group if k != at])
        assert one.advantage == pytest.approx(np.full(len(one.actions), came[at] - others), abs=1e-6)
    found.step()
    of_step = [set(one.advantage.tolist()) for one in found.collected]
    assert {len(values) for values in of_step} == {1}
    kept = experience_from_json([one.to_json() for one in found.collected], {e.id: e for e in found.episodes})
    assert [one.gained for one in kept] == [one.gained for one in found.collected]


def test_what_was_gained_is_the_sum_of_discounted_rewards(learner):
    found = learner(lasting())
    found.step()
    for one, replay in found.feeder([found.collected]).__next__():
        wanted = sum(0.99**k * float(reward) for k, reward in enumerate(replay.rewards))
        assert one.gained == pytest.approx(wanted, abs=1e-5)


def test_a_share_begins_near_the_end_of_the_solution(learner):
    """The steps before are kept, and the rewards of the policy's own steps are those of a replay."""
    found = learner(lasting(), rollouts={"episodes": 8, "backplay": 0.5, "backplay_steps": 5})
    found.step()
    led = [one for one in found.collected if one.led]
    assert 0 < len(led) < 8
    assert all(1 <= len(one.episode.solution) - len(one.led) <= 5 for one in led)
    for one in led:
        kept, again = _unpacked(found.feeder._kept[found.feeder._key(one)]), Replayer(found.act, found.make_env)(one)
        assert np.array_equal(kept.rewards, again.rewards)


def test_it_learns_what_pays(learner):
    """If only blocked moves cost something, it learns to avoid them."""
    env = functools.partial(UcONEnv, "mini", observe="pixels", reward=Reward(success=0, step=0, collision=-1))
    found = learner(lasting(), env=env, rollouts={"temperature": 1.0, "discount": 0.9}, steps=60, lr=0.01)

    def bumps():
        return np.mean([replay.rewards.sum() for _, replay in found.feeder([found.collected]).__next__()])

    costs = []
    for step in range(60):
        found.step()
        if step % 2 == 0:
            costs.append(bumps())
    assert np.mean(costs[-5:]) > np.mean(costs[:5]) / 2


@pytest.mark.slow
def test_collections_are_the_same_with_any_number_of_workers(learner):
    found = []
    for workers in (0, 1, 2):
        with closing(learner(TinyPolicy(dropout=0.1), steps=9, average=0.5, workers=workers)) as one:
            for _ in range(5):
                one.step()
            state = one.state_dict()
            found.append((state.values, {name: tensor.clone() for name, tensor in state.tensors.items()}))
    for values, tensors in found[1:]:
        assert values == found[0][0]
        assert all(torch.equal(tensor, found[0][1][name]) for name, tensor in tensors.items())


@pytest.mark.parametrize("at", [1, 2, 3])
def test_a_run_that_is_killed_goes_on_to_the_same_bytes(learner, tmp_path, at):
    """It is killed in the middle of a collection, before one, and just after one."""

    class KilledError(Exception):
        pass

    def kill(step, figures):
        if step == at and "loss" in figures:
            raise KilledError

    plan = Plan(steps=5, validate_every=5, save_every=1, keep=2)

    def made():
        return learner(TinyPolicy(dropout=0.1), steps=5, average=0.5)

    whole = TrainingRun(tmp_path / "whole", made(), plan, {})
    whole.start("a: 1\n")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", made(), plan, {})
    parts.start("a: 1\n")
    with pytest.raises(KilledError):
        parts.run(kill)
    again = TrainingRun(tmp_path / "parts", made(), plan, {})
    again.resume()
    again.run()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


def test_experience_is_read_as_it_was_written(learner):
    found = learner(rollouts={"backplay": 0.5})
    found.step()
    assert len({bool(one.led) for one in found.collected}) == 2
    rows = [one.to_json() for one in found.collected]
    again = experience_from_json(rows, {one.id: one for one in found.episodes})
    assert [one.to_json() for one in again] == rows


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda row: row[:4], "experience of another form"),
        (lambda row: ["elsewhere", *row[1:]], "trajectory of other episodes"),
        (lambda row: [*row[:4], row[4][:8], *row[5:]], "cut off or not finite"),
        (lambda row: [*row[:4], 7, *row[5:]], "cut off or not finite"),
        (lambda row: [*row[:5], "?" + row[5][1:], *row[6:]], "cut off or not finite"),
        (lambda row: [*row[:4], row[6], *row[5:]], "invalid experience"),
        (lambda row: [*row[:8], 2.0, row[9]], "invalid experience"),
        (lambda row: [*row[:9], float("nan")], "invalid experience"),
        (lambda row: [*row[:7], "yes", *row[8:]], "invalid experience"),
        (lambda row: [*row, "09"], "trajectory of other episodes"),
        (lambda row: [*row, "0", "0"], "experience of another form"),
    ],
)
def test_a_state_whose_experience_was_changed_is_refused(learner, change, message):
    found = learner(rollouts={"discount": 0.0})
    found.step()
    state = found.state_dict()
    rows = [change(row) for row in state.values["collected"]]
    if message == "invalid experience" and rows[0][4] != state.values["collected"][0][4]:  # probabilities above 1
        rows = [[*row[:4], _all_ones(len(row[2])), *row[5:]] for row in rows]
    with pytest.raises(DataError, match=message):
        learner().load_state_dict(dataclasses.replace(state, values={**state.values, "collected": rows}))


def _all_ones(length):
    import base64

    return base64.b64encode(np.ones(length, "<f4").tobytes()).decode()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"episodes": 0}, r"rollouts\.episodes=0: must be a whole number from 1"),
        ({"epochs": 1.5}, r"rollouts\.epochs=1\.5"),
        ({"discount": 1.5}, r"rollouts\.discount=1\.5: must be from 0 to 1"),
        ({"trace": True}, r"rollouts\.trace=True: must be from 0 to 1"),
        ({"backplay": 1.1}, r"rollouts\.backplay=1\.1: must be from 0 to 1"),
        ({"backplay_steps": 0}, r"rollouts\.backplay_steps=0: must be a whole number from 1"),
        ({"temperature": 0}, r"rollouts\.temperature=0: must be above 0"),
        ({"repeats": 0}, r"rollouts\.repeats=0: must be a whole number from 1"),
        ({"episodes": 10, "repeats": 4}, r"rollouts\.episodes=10: not a multiple of repeats=4"),
        ({"compare": "luck"}, r"rollouts\.compare=luck: must be spl or return"),
    ],
)
def test_rollouts_that_make_no_sense(options, message):
    with pytest.raises(ConfigError, match=message):
        EpisodeRollouts(**options)


def test_options_that_are_for_other_learners_are_refused(learner):
    with pytest.raises(ConfigError, match="PPO learns from its own play"):
        learner(demonstrator=object())
    with pytest.raises(ConfigError, match=r"choose=loss: expected success_rate or spl"):
        learner(validation={"choose": "loss"})
