"""Whole episodes in chunks: nothing is lost between chunks, and nothing leaks from one episode to another."""

import numpy as np
import pytest
import torch

from tests.learning.tiny_policy import ENV, TinyPolicy
from ucon.core.errors import ConfigError
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.sequence_loss import SequenceLoss, _told
from ucon.learning.imitation.trajectories import IGNORED, Trajectory, demonstration
from ucon.learning.policies.sequences import Batch, detached_state
from ucon.task.sets import load_episodes

EPISODES = sorted(load_episodes("mini"), key=lambda episode: len(episode.solution))[:6:2]
LOSS = SequenceLoss({"done": 5.0}, change=3.0, value=0.1)


@pytest.fixture(scope="module")
def pairs():
    trajectories = [demonstration(episode, "none") for episode in EPISODES]
    trajectories[1] = Trajectory(EPISODES[1], "gt", EPISODES[1].solution, "." + EPISODES[1].solution[1:])
    return next(iter(Feeder(TinyPolicy(), ENV)([trajectories])))


def logits_of(policy, pairs, steps, state_of=detached_state):
    """Logits of every step by episode id, read in chunks of ``steps``."""
    batch = Batch(pairs, 0.99, "cpu")
    order = sorted(pairs, key=lambda pair: -len(pair[1]))
    found = {trajectory.episode.id: [] for trajectory, _ in order}
    state = policy.initial_state(len(order))
    with torch.no_grad():
        for chunk in batch.chunks(steps):
            n = chunk.labels.shape[1]
            out = policy(chunk.frames, chunk.context, state_of(state, n))
            state = out.state
            for k in range(n):
                found[order[k][0].episode.id].append(out.logits[:, k][chunk.present[:, k]])
    return {name: torch.cat(parts) for name, parts in found.items()}


def test_chunks_and_company_change_nothing(pairs):
    """A chunked batch gives the same as each episode alone in one piece, so no state is lost."""
    policy = TinyPolicy().eval()
    alone = {}
    for pair in pairs:
        alone |= logits_of(policy, [pair], 1000)
    for steps in (1, 3, 8):
        for name, logits in logits_of(policy, pairs, steps).items():
            torch.testing.assert_close(logits, alone[name], atol=1e-5, rtol=1e-5)


def test_without_memory_every_step_comes_once_with_what_is_its_own(pairs):
    batch = Batch(pairs, 0.99, "cpu")
    chunks = list(batch.mixed(7, seed=1))
    assert [chunk.labels.shape[1] for chunk in chunks[:-1]] == [7] * (len(chunks) - 1)
    assert sum(chunk.labels.shape[1] for chunk in chunks) == sum(batch.lengths)

    def rows(labels, returns, changes, frames, context):
        flat = [
            labels,
            returns,
            changes,
            *(t.reshape(len(t), -1).double().sum(1) for t in (*frames.values(), *context.values())),
        ]
        return torch.stack([part.double() for part in flat], 1).tolist()

    found, wanted = [], []
    for chunk in chunks:
        assert chunk.present.all()
        one = {name: tensor[0] for name, tensor in chunk.frames.items()}
        found += rows(chunk.labels[0], chunk.returns[0], chunk.changes[0], one, chunk.context)
    for k, length in enumerate(batch.lengths):
        context = {name: tensor[k : k + 1].repeat_interleave(length, 0) for name, tensor in batch.context.items()}
        wanted += rows(batch.labels[k], batch.returns[k], batch.changes[k], batch.frames[k], context)
    assert found != wanted
    assert sorted(found) == sorted(wanted)
    assert torch.equal(chunks[0].labels, next(batch.mixed(7, seed=1)).labels)


def test_the_comparison_would_notice_a_lost_or_a_shifted_state(pairs):
    policy = TinyPolicy().eval()
    right = logits_of(policy, pairs, 3)
    lost = logits_of(policy, pairs, 3, lambda state, n: policy.initial_state(n))
    shifted = logits_of(policy, pairs, 3, lambda state, n: {k: v[:n].roll(1, 0) for k, v in state.items()})
    for wrong in (lost, shifted):
        assert max((wrong[name] - right[name]).abs().max() for name in right) > 1e-3


def test_labels_and_steps_are_all_there(pairs):
    batch = Batch(pairs, 0.99, "cpu")
    chunks = list(batch.chunks(5))
    assert batch.lengths == sorted((len(t.actions) for t, _ in pairs), reverse=True)
    assert sum(int(chunk.present.sum()) for chunk in chunks) == sum(batch.lengths)
    assert sum(int((chunk.labels != IGNORED).sum()) for chunk in chunks) == sum(batch.lengths) - 1
    assert [chunk.labels.shape[1] for chunk in chunks] == sorted((c.labels.shape[1] for c in chunks), reverse=True)


def test_the_loss_is_that_of_torch_over_labels_and_steps(pairs):
    policy = TinyPolicy().eval()
    batch = Batch(pairs, 0.9, "cpu")
    total, sums, state = (
        torch.zeros(()),
        torch.zeros(LOSS.n_sums, dtype=torch.float64),
        policy.initial_state(len(pairs)),
    )
    for chunk in batch.chunks(4):
        out = policy(chunk.frames, chunk.context, detached_state(state, chunk.labels.shape[1]))
        state = out.state
        loss, found = LOSS(out, chunk, LOSS.scale(batch))
        total, sums = total + loss, sums + found
    logits = torch.cat(list(logits_of(policy, pairs, 1000).values()))
    order = sorted(pairs, key=lambda pair: -len(pair[1]))
    labels = torch.from_numpy(np.concatenate([trajectory.classes for trajectory, _ in order]))
    each = torch.nn.functional.cross_entropy(logits, labels, ignore_index=IGNORED, reduction="none")
    before = [None, *labels.tolist()[:-1]]
    starts = {sum(len(t.actions) for t, _ in order[:k]) for k in range(len(order))}
    weight = torch.tensor(
        [
            (0.0 if label == IGNORED else 5.0 if label == 6 else 1.0) * (3.0 if k in starts or label != last else 1.0)
            for k, (label, last) in enumerate(zip(labels.tolist(), before, strict=True))
        ]
    )
    expected = (each * weight).sum() / weight.sum()
    figures = LOSS.figures(sums)
    assert figures["cross_entropy"] == pytest.approx(float(expected), rel=1e-4)
    assert figures["loss"] == pytest.approx(float(total.detach()), rel=1e-4)
    right = (logits.argmax(-1) == labels)[labels != IGNORED]
    assert figures["accuracy"] == pytest.approx(float(right.float().mean()))


def test_sums_are_where_the_frames_are():
    """There is no GPU here, so meta tensors show on which device the sums would be."""
    assert _told({"rgb": torch.zeros(2, 3, device="meta")}).device.type == "meta"
    assert not _told({"rgb": torch.zeros(2, 3)}).any()


def test_augmentation_is_one_for_an_episode(pairs):
    class Bright(TinyPolicy):
        def augment(self, frames, generator):
            draw = torch.rand(frames["depth"].shape[1], generator=generator)
            return {**frames, "depth": frames["depth"] + draw[:, None, None]}

    plain, bright, again, other = (Batch(pairs, 0.99, "cpu") for _ in range(4))
    bright.augment(Bright(), 1)
    again.augment(Bright(), 1)
    other.augment(Bright(), 2)
    added = [b["depth"] - a["depth"] for a, b in zip(plain.frames, bright.frames, strict=True)]
    assert all(float(one.max() - one.min()) < 0.02 for one in added), "steps of an episode differ"
    assert len({round(float(one.mean()), 2) for one in added}) == len(added), "episodes are alike"
    assert all(torch.equal(a["depth"], b["depth"]) for a, b in zip(bright.frames, again.frames, strict=True))
    assert not torch.equal(bright.frames[0]["depth"], other.frames[0]["depth"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"weights": {"don": 1.0}}, "unknown action 'don': did you mean done"),
        ({"weights": {"done": -1.0}}, r"weights\.done=-1\.0: must be from 0"),
        ({"value": float("nan")}, r"value=nan: must be from 0"),
        ({"discount": 1.5}, r"discount=1\.5: must be from 0 to 1"),
    ],
)
def test_losses_that_make_no_sense(options, message):
    with pytest.raises(ConfigError, match=message):
        SequenceLoss(**options)
