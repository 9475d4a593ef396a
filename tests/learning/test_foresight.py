"""Foresight from labelled decisions: the store, mirror images, and the learner."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from models.habit_policy import HabitPolicy
from tests.learning.tiny_search import search_of
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError, DataError
from ucon.learning.decisions import store
from ucon.learning.decisions.batches import batch_of, mirrored
from ucon.learning.decisions.decisions import TEXT
from ucon.learning.foresight.labels import Beyond
from ucon.learning.foresight.learner import ForesightLearner
from ucon.learning.run import kept_batches
from ucon.perception.detectors.gt import GtDetector

LEVELS = ("none", "retrieval")
BEYOND = Beyond()
GT = {"gt": GtDetector()}


@pytest.fixture(scope="module")
def search() -> Factory:
    return search_of("foresight")


@pytest.fixture(scope="module")
def cache(search: Factory, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A separate cache with the decisions of a few searches."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(folder))
        store.kept_decisions(BEYOND, "mini", 24, search, LEVELS, 0, 2)
    return folder


@pytest.fixture
def kept(cache: Path, search: Factory, monkeypatch: pytest.MonkeyPatch) -> store.Decisions:
    monkeypatch.setenv("UCON_CACHE", str(cache))
    return store.kept_decisions(BEYOND, "mini", 24, search, LEVELS, 0, 1)


@pytest.fixture
def learner(kept: store.Decisions, search: Factory, monkeypatch: pytest.MonkeyPatch) -> ForesightLearner:
    monkeypatch.setattr("ucon.learning.decisions.learner.check_parts", lambda *given: None)  # mini is no training set
    return made(search)


def made(search: Factory, **options) -> ForesightLearner:
    given = {
        "steps": 60, "episodes": "mini", "n_searches": 24, "validation": "mini", "validation_searches": 24,
        "levels": LEVELS, "batch": 64, "lr": 3e-3, "warm_up": 5, "decay": 0.0, "average": 0.5, "device": "cpu",
    }  # fmt: skip
    return ForesightLearner(HabitPolicy(16, 1, 2), search, GT, BEYOND, **{**given, **options})


def test_decisions_are_kept_and_the_number_of_workers_does_not_matter(
    cache: Path, search: Factory, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    files = sorted((cache / "foresight").rglob("*.safetensors"))
    assert [file.stem for file in files] == ["000000-8", "000008-8", "000016-8"]
    monkeypatch.setenv("UCON_CACHE", str(tmp_path))
    store.kept_decisions(BEYOND, "mini", 8, search, LEVELS, 0, 1)
    (one,) = (tmp_path / "foresight").rglob("*.safetensors")
    assert one.read_bytes() == files[0].read_bytes()
    monkeypatch.setattr(kept_batches, "open_pool", None)  # searching again would fail
    assert len(store.kept_decisions(BEYOND, "mini", 8, search, LEVELS, 0, 1))
    one.write_bytes(one.read_bytes()[:1000])
    with pytest.raises(DataError, match=r"no decisions .*remove it[^\n]*$"):
        store.kept_decisions(BEYOND, "mini", 8, search, LEVELS, 0, 1)


def test_a_batch_in_which_nothing_was_to_be_decided_is_kept_as_empty(
    search: Factory, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(Beyond, "__call__", lambda *given: None)
    file = tmp_path / "000000-1.safetensors"
    file.write_bytes(store._batch(BEYOND, "mini", search, LEVELS, 0, range(1)))
    assert store._read(file, BEYOND.label) is None


def test_other_episodes_levels_and_seeds_have_other_folders(search: Factory) -> None:
    found = {
        store.store_hash(BEYOND, "mini", search, LEVELS, 0), store.store_hash(BEYOND, "val", search, LEVELS, 0),
        store.store_hash(BEYOND, "mini", search, ("none",), 0), store.store_hash(BEYOND, "mini", search, LEVELS, 1),
    }  # fmt: skip
    assert len(found) == 4


def test_every_decision_has_its_episodes_text_and_what_lies_beyond(kept: store.Decisions) -> None:
    assert len(kept) == len(kept.frames["views"]) > 100
    assert {*kept.text} == {*TEXT}
    assert kept.episode.max() + 1 == len(kept.text["target"]) <= 24
    assert (np.diff(kept.episode) >= 0).all()
    beyond, offered = kept.frames["beyond"].astype(float), kept.frames["action_mask"] > 0
    assert beyond.min() >= 0.0
    assert beyond.max() <= 1.0
    assert (np.diff(beyond, axis=-1) >= 0).all()  # going farther never finds less
    assert (beyond[~offered] == 0).all()
    assert beyond[..., 2][offered].std() > 0.05


def test_a_mirror_keeps_what_lies_beyond_and_turned_twice_it_is_the_same(kept: store.Decisions) -> None:
    frames = batch_of(kept, np.arange(50))
    once = mirrored(frames)
    twice = mirrored(once)
    assert all(torch.equal(twice[name], frames[name]) for name in frames)
    assert not torch.equal(once["views"], frames["views"])
    assert not torch.equal(once["map"], frames["map"])
    for name in ("beyond", "prior", "thing_rows", "ego"):
        assert torch.equal(once[name], frames[name])


@pytest.mark.slow
def test_training_foresees_more_and_resumes_to_the_same_weights(learner: ForesightLearner, search: Factory) -> None:
    before = learner.validate()
    for _ in range(30):
        learner.step()
    half = learner.state_dict()
    kept = {name: value.clone() for name, value in half.tensors.items()}, dict(half.values)
    for _ in range(30):
        learner.step()
    after = learner.validate()
    assert after["foreseen"] > before["foreseen"] + 0.05  # measured in the homes it learns in
    again = made(search)
    again.load_state_dict(type(half)(*kept))
    for _ in range(30):
        again.step()
    assert again.product() == learner.product()


def test_only_foresight_learns(learner: ForesightLearner) -> None:
    before = {name: value.clone() for name, value in learner.network.state_dict().items()}
    for _ in range(3):
        learner.step()
    moved = {name for name, value in learner.network.state_dict().items() if not torch.equal(value, before[name])}
    for part in ("body.", "eye.", "foresee."):
        assert any(name.startswith(part) for name in moved)
    assert not any(name.startswith(("score.", "worth.", "sharpness")) for name in moved)


def test_wrong_options_are_refused(search: Factory, kept: store.Decisions) -> None:
    acting = torch.nn.Linear(2, 2)
    acting.chooses = "actions"
    with pytest.raises(ConfigError, match="scores views"):
        ForesightLearner(acting, search, GT, BEYOND, steps=1, lr=1e-3, warm_up=0, decay=0.0, average=0.0)
    with pytest.raises(ConfigError, match=r"learner\.detectors"):
        ForesightLearner(HabitPolicy(16, 1, 2), search, {}, BEYOND, steps=1, lr=1e-3, warm_up=0, decay=0.0, average=0.0)
    with pytest.raises(ConfigError, match="n_searches"):
        made(search, n_searches=0)
    with pytest.raises(ConfigError, match="train"):
        made(search, episodes="test")
