"""The judge of suspects: its data, its learner, and its files."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

from models.agents.judging import judge_of
from models.nets.judge import JudgeNet, TrainedJudge
from ucon.core.errors import ConfigError, DataError
from ucon.core.files import write_manifest
from ucon.fitting.suspect_cases import SuspectCases
from ucon.learning.judge import cases as judge_cases
from ucon.learning.judge.learner import CONFIG, WEIGHTS, JudgeLearner, auroc, measures
from ucon.learning.run import kept_batches
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.search.suspects import EVIDENCE, OF_HABITS, arithmetic


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A separate cache with the cases of a few searches."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(folder))
        judge_cases.collected("mini", 12, [NoisyDetector()], 0, 2)
    return folder


@pytest.fixture
def learner(cache: Path, monkeypatch: pytest.MonkeyPatch) -> JudgeLearner:
    monkeypatch.setenv("UCON_CACHE", str(cache))
    return made()


def made(**options) -> JudgeLearner:
    given = {"steps": 40, "searches": 12, "validation": "mini", "validation_searches": 10, "episodes": "mini"}
    net = partial(JudgeNet, 8, habits=options.pop("habits", True))
    return JudgeLearner(net, {"noisy": NoisyDetector()}, **{**given, **options})


@pytest.mark.slow
def test_cases_are_kept_and_the_number_of_workers_does_not_matter(
    cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    files = sorted((cache / "judge").rglob("*.safetensors"))
    assert len(files) == 2
    monkeypatch.setenv("UCON_CACHE", str(tmp_path))
    judge_cases.collected("mini", 10, [NoisyDetector()], 0, 1)
    (one,) = (tmp_path / "judge").rglob("*.safetensors")
    assert one.read_bytes() == files[0].read_bytes()
    monkeypatch.setattr(kept_batches, "open_pool", None)  # searching again would fail
    assert len(judge_cases.collected("mini", 10, [NoisyDetector()], 0, 1).home)
    one.write_bytes(one.read_bytes()[:100])
    with pytest.raises(DataError, match=r"no cases .*remove it[^\n]*$"):
        judge_cases.collected("mini", 10, [NoisyDetector()], 0, 1)


def test_cases_hold_the_truth(learner: JudgeLearner) -> None:
    cases = learner.cases
    assert cases.evidence.shape == (len(cases.home), len(EVIDENCE))
    assert np.isfinite(cases.evidence).all()
    suspects = cases.keep(cases.weight == 1.0)
    assert 0 < suspects.is_target.sum() < len(suspects.home)
    assert auroc(arithmetic(suspects.evidence), suspects.is_target) > 0.8


def test_training_lowers_the_loss_and_resumes_to_the_same_weights(learner: JudgeLearner) -> None:
    before = learner.validate()
    for _ in range(20):
        learner.step()
    half = learner.state_dict()
    kept = {name: value.clone() for name, value in half.tensors.items()}, dict(half.values)
    for _ in range(20):
        learner.step()
    assert learner.validate()["nll"] < before["nll"]
    again = made()
    again.load_state_dict(type(half)(*kept))
    for _ in range(20):
        again.step()
    assert again.product() == learner.product()


def test_the_product_is_a_judge_and_damaged_ones_are_refused(learner: JudgeLearner, tmp_path: Path) -> None:
    for _ in range(3):
        learner.step()
    files = learner.product()
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    write_manifest(tmp_path, files)
    judge = TrainedJudge.load(tmp_path)
    with learner.updates.averaged(), torch.no_grad():
        wanted = torch.sigmoid(learner.net.eval()(torch.from_numpy(learner.cases.evidence)).double()).numpy()
    assert judge(learner.cases.evidence) == pytest.approx(wanted, abs=1e-5)
    assert len(judge.fingerprint()) == 64
    for name, content in ((WEIGHTS, files[WEIGHTS][:-8]), (CONFIG, b"{}"), (CONFIG, b"[nan]")):
        other = tmp_path / f"damaged {name} {len(content)}"
        other.mkdir()
        for each, kept in {**files, name: content}.items():
            (other / each).write_bytes(kept)
        write_manifest(other, files)
        with pytest.raises(DataError, match=r"^[^\n]+$"):
            TrainedJudge.load(other)


def test_a_judge_trained_further_begins_as_it_was(learner: JudgeLearner, tmp_path: Path) -> None:
    for _ in range(5):
        learner.step()
    files = learner.product()
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    write_manifest(tmp_path, files)
    further = made(initial=str(tmp_path), searches=10)
    assert further.product()[WEIGHTS] == files[WEIGHTS], "on other cases, with the scale that its weights belong to"
    assert "initial" in further.identity


def test_without_habits_they_change_nothing() -> None:
    torch.manual_seed(0)
    net, rows = JudgeNet(8, habits=False), torch.randn(5, len(EVIDENCE))
    other = rows.clone()
    other[:, [EVIDENCE.index(name) for name in OF_HABITS]] += 3.0
    assert torch.equal(net(rows), net(other))
    assert not torch.equal(JudgeNet(8)(rows), JudgeNet(8)(other))


def test_the_shipped_judge_is_better_than_the_arithmetic(learner: JudgeLearner) -> None:
    suspects = learner.validation.keep(learner.validation.weight == 1.0)
    judged = measures(TrainedJudge.load()(suspects.evidence), suspects)
    assert judged["nll"] < measures(arithmetic(suspects.evidence), suspects)["nll"]
    assert judged["auroc"] > 0.9


def test_measures_of_known_cases() -> None:
    true = np.array([True, False, True, False])
    assert auroc(np.array([0.9, 0.1, 0.8, 0.2]), true) == 1.0
    assert auroc(np.full(4, 0.5), true) == 0.5
    assert auroc(np.array([0.1, 0.9, 0.2, 0.8]), true) == 0.0
    assert auroc(np.array([0.3]), np.array([True])) == 0.5
    rows = SuspectCases(np.zeros((4, len(EVIDENCE)), np.float32), true, np.ones(4, np.float32), np.zeros(4, np.int32))
    assert measures(np.array([1.0, 0.0, 1.0, 0.0]), rows)["ece"] == 0.0
    assert measures(np.full(4, 0.5), rows)["nll"] == pytest.approx(np.log(2.0), abs=1e-4)


@pytest.mark.parametrize("value", [0, 2.5, True, "x"])
def test_widths_are_checked(value: object) -> None:
    with pytest.raises(ConfigError, match="width"):
        JudgeNet(value)  # type: ignore[arg-type]


def test_judges_are_configured_by_name(tmp_path: Path) -> None:
    assert judge_of(None) is None
    shipped = judge_of("shipped")
    assert shipped is not None
    assert shipped.fingerprint() == TrainedJudge.load().fingerprint()
    missing = judge_of(str(tmp_path / "none"))
    assert missing is not None
    with pytest.raises(ConfigError, match="no such folder"):
        missing.check()
    with pytest.raises(ConfigError, match=r"agent\.judge"):
        judge_of(3)  # type: ignore[arg-type]
