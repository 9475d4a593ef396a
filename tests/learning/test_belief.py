"""Training of the belief head on a part of the book, and what it may learn from."""

import json
import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch
from safetensors.torch import load, save

from models.nets.belief.belief_head import BeliefHead
from models.nets.belief.head_reader import HeadReader
from tests.learning.belief_tiny import plain_parts, small_head, tiny_belief
from tests.learning.tiny import some_habits
from ucon.core.errors import ConfigError, DataError, DivergedError
from ucon.core.files import write_manifest
from ucon.core.rng import stream
from ucon.habits import book
from ucon.habits.splits import entry_parts
from ucon.habits.types import HabitDataset
from ucon.learning.belief_head.crossfit import fold_categories
from ucon.learning.belief_head.draws import Draw, Draws, sample
from ucon.learning.belief_head.households import KnowledgeBases, pair_folds
from ucon.learning.belief_head.learner import CONFIG, PRIOR, WEIGHTS, BeliefLearner
from ucon.learning.belief_head.losses import losses
from ucon.learning.run.stopping import Stopping
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun
from ucon.readers.sampled_homes import entry_kb, sampled_kb
from ucon.retrieval.levels import FIXED_LEVELS


def test_learns():
    learner = tiny_belief(steps=60, households=2)
    before = learner.validate()["score"]
    for _ in range(40):
        learner.step()
    assert learner.validate()["score"] > before + 0.1


def test_a_resumed_run_is_bit_identical(tmp_path):
    plan = Plan(steps=6, validate_every=3, save_every=2)
    whole = TrainingRun(tmp_path / "whole", tiny_belief(), plan, {})
    whole.start("")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", tiny_belief(), plan, {})
    parts.start("")
    parts._begin(Stopping(print), lambda step, figures: None)
    for _ in range(4):
        parts._one_step(Stopping(print), lambda step, figures: None)
    again = TrainingRun(tmp_path / "parts", tiny_belief(), plan, {})
    again.resume()
    assert again.step == 4
    again.run()
    for name in (METRICS, f"model/{WEIGHTS}", f"model/{CONFIG}", "MODEL_CARD.md"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes()
    for name, value in whole.learner.state_dict().tensors.items():
        assert torch.equal(value, again.learner.state_dict().tensors[name])


@pytest.mark.parametrize("switch", ["pairs", "evidence", "gate", "sentences", "prior"])
def test_ablations_can_be_resumed(switch):
    learner = tiny_belief(head={switch: False})
    learner.step()
    again = tiny_belief(head={switch: False})
    again.load_state_dict(learner.state_dict())
    assert again.step() == learner.step()


def test_numbers_that_are_none_stop_it_by_name():
    learner = tiny_belief()
    first = next(iter(learner.updates.parameters.values()))
    with torch.no_grad():
        first.fill_(float("nan"))
    with pytest.raises(DivergedError, match=r"step 1: gradient of \w+") as stop:
        learner.step()
    assert "\n" not in str(stop.value)


def test_state_of_another_head_is_refused():
    with pytest.raises(DataError, match="names or shapes differ"):
        tiny_belief().load_state_dict(tiny_belief(head={"width": 8}).state_dict())


def test_a_head_of_homes_keeps_their_common_sense(tmp_path):
    learner = BeliefLearner(partial(small_head), in_two_homes(), steps=4, households=1, n_kbs=2)
    files = learner.product()
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    write_manifest(tmp_path, list(files))
    prior, fitted = HeadReader.load(tmp_path).parts.own_prior, learner._parts.own_prior
    assert prior.names == fitted.names
    assert np.allclose(prior.dense, fitted.dense, atol=1e-2)
    vector = learner._parts.vectors(["mug"])
    assert prior.log_p(vector, [prior.names[0], "no such thing"], -9.0)[0, 1] == -9
    (tmp_path / PRIOR).write_bytes(b"PK no archive")
    write_manifest(tmp_path, list(files))
    with pytest.raises(DataError, match="no anchor prior"):
        HeadReader.load(tmp_path)


def test_an_entry_is_asked_about_among_training_entries_of_its_home():
    data = in_two_homes()
    parts = entry_parts(data)
    entry = next(e for e in data.entries if parts[e.id] == "test")
    kb = entry_kb(data, entry, 0, k=5)
    assert len(kb.entries) == 5
    others = [e for name, entries in kb.entries.items() for e in entries if name != entry.category]
    assert list(kb.entries[entry.category]) == [entry]
    assert {(parts[e.id], e.scene) for e in others} == {("train", entry.scene)}


def test_it_may_begin_with_another_head(tmp_path):
    taught = tiny_belief()
    taught.step()
    for name, content in taught.product().items():
        (tmp_path / name).write_bytes(content)
    write_manifest(tmp_path, [WEIGHTS, CONFIG])
    again = tiny_belief(initial=str(tmp_path), seed=7)
    for name, value in again.updates.parameters.items():
        assert torch.allclose(value, taught.updates.average[name], atol=2e-3), name
    assert float(again.head.temperature) == 1
    with pytest.raises(DataError, match=rf"{WEIGHTS}: \w\S* is \(.*\), expected \(.*\); it belongs to another"):
        tiny_belief(initial=str(tmp_path), head={"width": 8})
    for raw, message in (
        (pickle.dumps({"a": 1}), "a pickle, which is never read"),
        (numberless(tmp_path), "not finite"),
    ):
        (tmp_path / WEIGHTS).write_bytes(raw)
        write_manifest(tmp_path, [WEIGHTS, CONFIG])
        with pytest.raises(DataError, match=message) as caught:
            tiny_belief(initial=str(tmp_path))
        assert "\n" not in str(caught.value)


def numberless(folder):
    return save({name: value * torch.nan for name, value in load((folder / WEIGHTS).read_bytes()).items()})


@pytest.mark.parametrize("option", [{"steps": 0}, {"households": 1.5}, {"n_kbs": True}])
def test_counts_of_the_wrong_kind_are_refused(option):
    with pytest.raises(ConfigError, match="above 0 and whole"):
        tiny_belief(**option)


@pytest.mark.parametrize("option", [{"lr": -1}, {"average": 1.5}, {"decay": -1}, {"relevance": -0.1}])
def test_numbers_out_of_range_are_refused(option):
    with pytest.raises(ConfigError, match=f"learner.{next(iter(option))}="):
        tiny_belief(**option)


@pytest.mark.parametrize("option", [{"width": 127}, {"heads": 0}, {"blocks": -1}, {"dropout": 2}])
def test_heads_that_cannot_be_are_refused(option):
    with pytest.raises(ConfigError, match=r"learner\.head\."):
        BeliefHead(**option)


@pytest.mark.parametrize(
    "option",
    [{"swap": 1.5}, {"levels": (0, 0, 0, 0)}, {"levels": None}, {"targets": 0}, {"targets": 1.5}, {"dropped": "half"}],
)
def test_draws_out_of_range_are_refused(option):
    with pytest.raises(ConfigError, match=r"draw\."):
        Draw(**option)


def in_two_homes() -> HabitDataset:
    """One entry per category of the book, in two homes in turn, without labels of what habits support."""
    data, entries = some_habits(3), []
    for number, name in enumerate(data.categories):
        home = f"home_{number % 2}"
        entries.append(replace(data.entries_of(name)[0], scene=home))
    return HabitDataset("homes", tuple(entries), labelled=False)


@pytest.mark.parametrize("dataset", [book(), in_two_homes()], ids=["book", "homes"])
def test_only_training_entries_teach_and_others_are_asked_about_alone(dataset):
    bases, parts = KnowledgeBases(dataset, plain_parts().known), entry_parts(dataset)
    for number in range(40):
        kb = bases.drawn("train", number, "category")
        assert {parts[dataset.entry_of(int(row)).id] for row in kb.rows} == {"train"}
    for kb in bases.several("val", 0, 4):
        asked = bases.targets(kb, "val")
        assert asked
        assert {parts[entry.id] for name in asked for entry in kb.entries[name]} == {"val"}
        named = {place.anchor for name in asked for entry in kb.entries[name] for place in entry.placements}
        assert named <= set(bases.candidates(kb))


def test_habits_of_homes_are_read_by_the_shipped_parts(monkeypatch):
    """The shipped parts were not fitted on these habits, so nothing is held out."""
    monkeypatch.setattr("ucon.learning.belief_head.held_out_readers.book_folds", None)
    learner = BeliefLearner(partial(small_head), in_two_homes(), steps=4, parts=plain_parts(), households=1, n_kbs=2)
    before = learner.validate()["score"]
    assert learner.step()["loss"] > 0
    assert learner.validate()["score"] != before
    assert "of `homes`" in learner.card().text


def test_pairs_are_asked_about_with_the_common_sense_of_the_others():
    data = in_two_homes()
    parts = entry_parts(data)
    taught = {(e.scene, e.category) for e in data.entries if parts[e.id] == "train"}
    folds = pair_folds(data, 4)
    assert sorted(pair for pairs, _ in folds for pair in pairs) == sorted(taught)
    for pairs, others in folds:
        assert {(e.scene, e.category) for e in others} == taught - pairs
        bases = KnowledgeBases(data, plain_parts().known)
        kb = bases.asked("train", 5, "task", pairs)
        targets = Draws(plain_parts(), Draw(), (), pairs)._asked(kb)
        assert targets
        assert {(kb.entries[name][0].scene, name) for name in targets} == pairs & {
            (e[0].scene, name) for name, e in kb.entries.items()
        }
    with pytest.raises(DataError, match="too few train targets"):
        bases.asked("train", 5, "task", frozenset({("nowhere", "mug")}))


def test_all_that_stands_in_a_scene_may_be_a_place():
    data = in_two_homes()
    bases = KnowledgeBases(replace(data, standing={"home_0": ("griffin", "unicorn")}), plain_parts().known)
    for kb in bases.several("val", 0, 4):
        there = {"griffin", "unicorn"} <= set(bases.candidates(kb))
        assert there == (next(iter(kb.entries.values()))[0].scene == "home_0")


@pytest.mark.parametrize("option", [{"n_folds": 3}, {"used_folds": 1}])
def test_folds_of_habits_that_belong_to_scenes_are_refused(option):
    ((name, value),) = option.items()
    with pytest.raises(ConfigError, match=rf"learner\.{name}={value}.* homes is split by scene") as caught:
        BeliefLearner(partial(small_head), in_two_homes(), steps=4, **option)
    assert "\n" not in str(caught.value)


def test_folds_share_the_train_categories_out():
    groups = fold_categories(book(), 3)
    names = [name for group in groups for name in group]
    assert len(names) == len(set(names)) > 300
    assert max(map(len, groups)) - min(map(len, groups)) <= 1
    with pytest.raises(ConfigError, match="expected 2 to"):
        fold_categories(book(), 1)


@pytest.fixture(scope="module")
def drawn():
    """Many draws of one knowledge base, each augmentation always on."""
    always = {"remove": 1, "hide": 1, "drop": 1, "mute": 1}
    kb = sampled_kb(book(), "train", 3, "task")
    quiet = Draw(swap=0, **dict.fromkeys(always, 0))
    kinds = {"plain": quiet, **{k: Draw(**{**vars(quiet), k: 1}) for k in ("swap", *always)}}
    return kb, {name: Draws(plain_parts(), draw)(kb, stream(1, "draw")) for name, draw in kinds.items()}


def test_truth_adds_up(drawn):
    _, found = drawn
    for one in found.values():
        assert np.allclose(one.truth.anchor.sum(1), 1, atol=1e-5)
        assert (one.truth.weight[~one.inputs.given] == 0).all()
    for name in ("plain", "swap", "drop", "mute", "hide"):
        assert (found[name].truth.anchor[:, -1] == 0).all(), "all anchors are candidates"
    assert found["remove"].truth.anchor[:, -1].sum() > 0


def test_relations_are_part_of_the_anchors(drawn):
    one = drawn[1]["plain"]
    assert np.allclose(one.truth.relation.sum(2), one.truth.anchor[:, :-1], atol=1e-5)


def test_swapped_names_keep_what_is_said_with_the_place(drawn):
    """The same draw with names exchanged: pair inputs and truth stay, names and common sense move together."""
    plain, swap = drawn[1]["plain"], drawn[1]["swap"]
    assert np.array_equal(plain.inputs.pair, swap.inputs.pair)
    assert np.array_equal(plain.truth.anchor, swap.truth.anchor)
    moved = np.flatnonzero((plain.inputs.name != swap.inputs.name).any(1))
    assert len(moved) > 10
    for c in moved:
        origin = np.flatnonzero((plain.inputs.name == swap.inputs.name[c]).all(1))[0]
        assert np.array_equal(swap.inputs.prior[:, c], plain.inputs.prior[:, origin])
        assert np.array_equal(swap.inputs.relation_prior[c], plain.inputs.relation_prior[origin])
    assert not swap.inputs.sentence.any(), "the vectors still speak the old names"
    assert (swap.truth.relation[:, moved] == 0).all()


def test_levels_give_what_they_say(drawn):
    kb, _ = drawn
    target = next(iter(kb.entries))
    one = sample(kb, plain_parts(), book().anchors, [target] * 4, FIXED_LEVELS)
    none, full, gt, retrieval = one.inputs.given.sum(1)
    assert (none, full, retrieval) == (0, len(kb), 20)
    assert gt == len(kb.rows_about(target))
    assert list(one.inputs.trusted) == [False, False, True, False]


def test_losses_are_finite_at_every_level(drawn):
    learner = tiny_belief()
    for one in drawn[1].values():
        found = losses(learner.head(one.inputs), one.truth)
        assert all(torch.isfinite(value) for value in found.values())


def test_product_says_how_to_build_it():
    files = tiny_belief().product()
    assert json.loads(files[CONFIG])["head"]["width"] == 16
    assert set(files) == {WEIGHTS, CONFIG}


def test_one_of_everything_is_enough_to_begin():
    learner = BeliefLearner(partial(small_head), in_two_homes(), steps=1, households=1, n_kbs=1, warm_up=1)
    assert learner.step()["loss"] > 0
