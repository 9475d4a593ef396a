"""The belief head: any number of habits and candidates, in any order, at any level."""

from dataclasses import fields, replace

import numpy as np
import pytest
import torch

from models.nets.belief.belief_head import BeliefHead
from tests.learning.belief_tiny import plain_parts
from ucon.habits import book
from ucon.learning.belief_head.draws import sample
from ucon.readers.household import Candidates, Household
from ucon.readers.sampled_homes import sampled_kb
from ucon.retrieval.levels import FIXED_LEVELS


def lively_head(**options):
    """A head with random weights everywhere; in a fresh head some are zero."""
    torch.manual_seed(1)
    head = BeliefHead(**{"width": 32, **options}).eval()
    with torch.no_grad():
        for value in head.parameters():
            value.add_(0.1 * torch.randn(value.shape))
    return head


@pytest.fixture(scope="module", params=[(), ("pools",), ("mixture",), ("pools", "mixture")], ids=", ".join)
def head(request):
    return lively_head(**dict.fromkeys(request.param, True))


@pytest.fixture(scope="module")
def inputs():
    kb = sampled_kb(book(), "train", 5, "task")
    target = next(iter(kb.entries))
    return sample(kb, plain_parts(), book().anchors[:30], [target] * 4, FIXED_LEVELS).inputs


def run(head, inputs):
    with torch.no_grad():
        return head(inputs)


def test_size_and_shapes(head, inputs):
    assert 3e5 < sum(value.numel() for value in BeliefHead().parameters()) <= 1e6
    outputs = run(head, inputs)
    t, h = inputs.given.shape
    assert outputs.anchor.shape == (t, 30)
    assert outputs.unseen.shape == (t,)
    assert outputs.relation.shape == (t, 30, 4)
    assert outputs.relevance.shape == (t, h)
    assert torch.allclose(outputs.log_p.exp().sum(1), torch.ones(t), atol=1e-5)


def test_order_of_candidates_means_nothing(head, inputs):
    order = np.random.default_rng(0).permutation(30)
    moved = {"pair": inputs.pair[:, order], "prior": inputs.prior[:, order], "open": inputs.open[:, order]}
    alone = {key: getattr(inputs, key)[order] for key in ("name", "candidate", "relation_prior")}
    before, after = run(head, inputs), run(head, replace(inputs, **moved, **alone))
    assert torch.allclose(before.anchor[:, order], after.anchor, atol=1e-4)
    assert torch.allclose(before.relation[:, order], after.relation, atol=1e-4)


def test_order_of_habits_means_nothing(head, inputs):
    order = np.random.default_rng(0).permutation(len(inputs.sentence))
    alone = {key: getattr(inputs, key)[order] for key in ("sentence", "habit", "pair")}
    shared = {key: getattr(inputs, key)[:, order] for key in ("relevance", "given")}
    before, after = run(head, inputs), run(head, replace(inputs, **alone, **shared))
    assert torch.allclose(before.anchor, after.anchor, atol=1e-4)
    assert torch.allclose(before.relevance[:, order], after.relevance, atol=1e-4)


def test_habits_that_are_not_given_change_nothing(head, inputs):
    """The target's own habits alone give the same as among all others, which are masked."""
    rows, t = np.flatnonzero(inputs.given[2]), slice(2, 3)
    alone = {key: getattr(inputs, key)[rows] for key in ("sentence", "habit", "pair")}
    shared = {key: getattr(inputs, key)[t][:, rows] for key in ("relevance", "given")}
    own = {key: getattr(inputs, key)[t] for key in ("target", "prior", "trusted", "open")}
    few = run(head, replace(inputs, **alone, **shared, **own))
    many = run(head, inputs)
    assert torch.allclose(few.anchor[0], many.anchor[2], atol=1e-4)
    assert torch.allclose(few.unseen[0], many.unseen[2], atol=1e-4)
    assert torch.allclose(few.relation[0], many.relation[2], atol=1e-4)


def test_a_candidate_more_changes_no_other(head, inputs):
    few = replace(
        inputs,
        **{key: getattr(inputs, key)[:20] for key in ("name", "candidate", "relation_prior")},
        **{key: getattr(inputs, key)[:, :20] for key in ("pair", "prior", "open")},
    )
    assert torch.allclose(run(head, few).anchor, run(head, inputs).anchor[:, :20], atol=1e-4)


def test_no_habits_and_no_candidates(head):
    parts = plain_parts()
    for names in (("sofa", "desk"), ()):
        household, candidates = Household(parts, ()), Candidates.of(names, parts)
        given, trusted = np.ones((1, 0), bool), np.asarray([True])
        outputs = run(head, household.inputs(["wallet"], candidates, given, trusted))
        assert torch.isfinite(outputs.log_p).all()
        assert outputs.anchor.shape == (1, len(names))


def test_the_target_is_no_place_for_itself(head):
    parts = plain_parts()
    household = Household(parts, ("The kettle stands on the stove.",))
    inputs = household.inputs(
        ["kettle"], Candidates.of(("kettle", "sofa"), parts), np.ones((1, 1), bool), np.ones(1, bool)
    )
    assert run(head, inputs).log_p.exp()[0, 0] < 1e-12


def test_deterministic(head, inputs):
    assert torch.equal(run(head, inputs).anchor, run(head, inputs).anchor)
    assert torch.equal(lively_head(pools=head.pools, mixture=head.mixture).look.score.weight, head.look.score.weight)


@pytest.mark.parametrize("switch", ["pairs", "evidence", "gate", "sentences", "prior"])
def test_switches_leave_out_what_they_say(switch, inputs):
    without = lively_head(**{switch: False})
    same = run(without, inputs)
    if switch == "gate":
        assert not torch.allclose(same.anchor, run(lively_head(), inputs).anchor)
        return
    names = {
        "pairs": {"pair": inputs.pair * np.r_[np.zeros(6), np.ones(3)].astype(np.float32)},
        "evidence": {
            "pair": inputs.pair * np.r_[np.ones(6), np.zeros(3)].astype(np.float32),
            "habit": np.zeros_like(inputs.habit),
        },
        "sentences": {key: np.zeros_like(getattr(inputs, key)) for key in ("sentence", "name", "target")},
        "prior": {"prior": np.zeros_like(inputs.prior)},
    }[switch]
    assert torch.allclose(same.anchor, run(without, replace(inputs, **names)).anchor, atol=1e-5)
    assert not torch.allclose(run(lively_head(), inputs).anchor, run(lively_head(), replace(inputs, **names)).anchor)


def test_gradients_reach_every_parameter(inputs):
    head = lively_head().train()
    outputs = head(inputs)
    loss = (outputs.log_p[:, :-1] * torch.randn(4, 30)).sum() + outputs.relation.square().sum()
    (loss + outputs.relevance.sum()).backward()
    assert {name for name, value in head.named_parameters() if value.grad is None} == set()


def test_inputs_are_named_alike():
    from models.nets.belief.belief_head import Inputs
    from ucon.readers.head_inputs import HeadInputs

    assert [f.name for f in fields(Inputs)] == [f.name for f in fields(HeadInputs)]


@pytest.mark.parametrize("level", FIXED_LEVELS)
def test_begins_with_the_mixture_of_what_is_said_and_common_sense(inputs, level):
    head, row = BeliefHead(sentences=False, mixture=True).eval(), slice(FIXED_LEVELS.index(level), None)
    own = ("given", "relevance", "target", "prior", "open")
    one = replace(inputs, trusted=np.ones(1, bool), **{name: getattr(inputs, name)[row][:1] for name in own})
    with torch.no_grad():
        p = head(one).anchor[0].softmax(0).numpy()
    said = one.given[0] @ one.pair[:, :, -3]
    assert (said.max() > 0.1) == (level != "none")
    mass = (said + np.exp(one.prior[0])) * one.open[0]
    assert np.allclose(p, mass / mass.sum(), atol=1e-2)
