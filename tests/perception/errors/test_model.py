"""The file of a detector's errors, and its probabilities."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from ucon.core.errors import ConfigError, DataError
from ucon.perception.detectors.base import vocabulary
from ucon.perception.errors.model import DetectorErrors, parse_errors, read_errors

CONFIGS = Path(__file__).resolve().parents[3] / "configs" / "detector"
NOISY = sorted(path.stem for path in CONFIGS.glob("noisy*.yaml"))


@pytest.fixture(scope="module")
def errors() -> DetectorErrors:
    return read_errors("noisy")


@pytest.mark.parametrize("name", NOISY)
def test_the_simulated_detectors_errors_come_with_the_package(name: str) -> None:
    found = read_errors(name)
    assert found.detector == name
    assert found.looks > 50_000
    assert parse_errors(found.to_json(), "again") == found
    assert len(found.fingerprint()) == 64


def test_stronger_noise_is_fitted_as_such() -> None:
    low, middle, high = (read_errors(name) for name in ("noisy_low", "noisy", "noisy_high"))
    for a, b in ((low, middle), (middle, high)):
        assert a.right > b.right
        assert a.false_boxes < b.false_boxes
        far = np.array([1.0, 2.0, 4.0])
        assert (a.sighted_curve("mug", far) > b.sighted_curve("mug", far)).all()
        assert a.evidence(0.9) - a.evidence(0.35) > b.evidence(0.9) - b.evidence(0.35)


def test_large_near_and_whole_things_are_found_more_often(errors: DetectorErrors) -> None:
    one = np.ones(1)
    usual = errors.found(100 * one, 2 * one, one)
    assert 0.5 < usual < 0.9
    assert errors.found(10 * one, 2 * one, one) < usual < errors.found(600 * one, 2 * one, one)
    assert errors.found(100 * one, 6 * one, one) < usual
    assert errors.found(100 * one, 2 * one, 0.2 * one) < usual - 0.1
    curve = errors.sighted_curve("mug", np.array([1.0, 2.0, 4.0, 8.0]))
    assert (np.diff(curve) < 0).all()
    assert errors.sighted_curve("no such thing", one) > 0


def test_wrong_names_are_those_of_similar_things(errors: DetectorErrors) -> None:
    names = vocabulary()
    chance = np.exp(errors.called.astype(float))
    assert chance.shape == (len(names), len(names))
    assert np.allclose(chance.sum(1), 1.0, atol=1e-3)
    assert chance.diagonal().max() < 1e-6
    mug = chance[names.index("mug")]
    assert mug[names.index("coffee_cup")] > 20 * mug[names.index("sofa")]
    assert dict(zip(errors.names, errors.counts, strict=True))["straight_chair"] > 1.0


WRONG = {
    "truncated": lambda text: text[:-40],
    "NaN": lambda text: text.replace('"right":', '"right":NaN,"was":'),
    "a chance of two": lambda text: json.dumps(json.loads(text) | {"right": 2.0}),
    "no side": lambda text: json.dumps(json.loads(text) | {"sides": 0}),
    "a weight missing": lambda text: json.dumps(json.loads(text) | {"recall": json.loads(text)["recall"][:-1]}),
    "a name without a count": lambda text: json.dumps(json.loads(text) | {"counts": [1.0]}),
    "another vocabulary": lambda text: json.dumps(json.loads(text) | {"vocabulary": "0" * 64}),
    "texts for numbers": lambda text: json.dumps(json.loads(text) | {"knots": "12"}),
    "a list": lambda text: "[]",
    "something else": lambda text: "mug",
}


@pytest.mark.parametrize("how", WRONG)
def test_what_is_no_file_of_errors_is_refused_in_one_line(errors: DetectorErrors, tmp_path: Path, how: str) -> None:
    path = tmp_path / "noisy.json"
    path.write_text(WRONG[how](errors.to_json()))
    with pytest.raises(DataError) as caught:
        read_errors("noisy", path)
    assert "\n" not in str(caught.value)
    assert "python -m ucon detector fit" in str(caught.value)


def test_errors_of_another_detector_are_refused(errors: DetectorErrors, tmp_path: Path) -> None:
    path = tmp_path / "errors.json"
    path.write_text(dataclasses.replace(errors, detector="owlv2").to_json())
    with pytest.raises(ConfigError, match=r"the errors of owlv2, expected those of noisy; fit them"):
        read_errors("noisy", path)
    with pytest.raises(ConfigError, match=r"no such file; fit them.*detector fit noisy FILE"):
        read_errors("noisy", tmp_path / "none.json")
    with pytest.raises(ConfigError, match="do not come with the package"):
        read_errors("yolo_world")
