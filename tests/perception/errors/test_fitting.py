"""Errors are fitted on looks with known truth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

from ucon.__main__ import main
from ucon.core.errors import DataError
from ucon.fitting.detector_errors import fit_errors, look_key
from ucon.fitting.detector_looks import FalseBoxes, Looks, collect
from ucon.fitting.reliability import reliability
from ucon.perception.detectors.base import vocabulary
from ucon.perception.detectors.confusion import wrong_name
from ucon.perception.detectors.noise_rates import EXACT, Rates
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.task.sets import load_episodes


def made(n: int = 20_000, right: float = 0.7, *, seed: int = 0) -> tuple[Looks, FalseBoxes]:
    """Looks by a known rule: the chance depends only on size, and errors persist within a quarter turn."""
    draw = np.random.default_rng(seed)
    home, thing = np.arange(n) % 40, draw.integers(0, 50, n)
    name = (thing * 7) % len(vocabulary())
    pixels, away = np.exp(draw.uniform(np.log(4), np.log(2000), n)), draw.uniform(0.5, 5.0, n)
    bearing = draw.uniform(-np.pi, np.pi, n)
    key = look_key(bearing, away, 4, 8.0) + 4096 * (1000 * home + thing)
    _, of = np.unique(key, return_inverse=True)
    chance = 1 / (1 + np.exp(3.0 - np.log(pixels)))
    found = draw.random(of.max() + 1)[of] < chance
    is_right = draw.random(n) < right
    names = vocabulary()
    wrong = [names.index(wrong_name(names[k], u)) for k, u in zip(name.tolist(), draw.random(n).tolist(), strict=True)]
    called = np.where(found, np.where(is_right, name, wrong), -1)
    score = np.where(found, 1 / (1 + np.exp(-draw.standard_normal(n) - is_right)), 0.0)
    columns = (pixels, pixels, away, bearing)
    looks = Looks(home.astype(np.int32), thing.astype(np.int32), name.astype(np.int32), *columns, found, called, score)
    return looks, FalseBoxes(5000, 1 / (1 + np.exp(-draw.standard_normal(1000))))


def test_a_known_rule_is_found_again() -> None:
    looks, false = made()
    errors = fit_errors("made", looks, false)
    px, two = np.array([8.0, 60.0, 500.0]), np.full(3, 2.0)
    assert errors.found(px, two, np.ones(3)) == pytest.approx(1 / (1 + np.exp(3.0 - np.log(px))), abs=0.04)
    assert errors.right == pytest.approx(0.7, abs=0.02)
    assert errors.false_boxes == pytest.approx(0.2)
    assert errors.sides == 4
    assert errors.repeats > 0.3  # below 1, since chances differ with the pixels of a look
    assert errors.repeats_elsewhere < 0.1
    # Of two normal distributions one apart, the logit of the score has a likelihood ratio of exp(z - 1/2).
    assert errors.evidence(0.5) == pytest.approx(-0.5, abs=0.3)
    assert errors.evidence(0.8) - errors.evidence(0.5) == pytest.approx(np.log(4), abs=0.5)
    assert errors.confusion[0] == pytest.approx(1.0, abs=0.3)
    assert errors.confusion[1] == pytest.approx(np.log(6), abs=0.4)
    assert "0.0" in reliability("made", looks, false).text.splitlines()[-1]


@pytest.mark.parametrize("n", [0, 100, 1900])
def test_too_few_looks_are_refused(n: int) -> None:
    looks, false = made()
    with pytest.raises(DataError, match="walk through more homes"):
        fit_errors("made", looks.keep(np.arange(len(looks.name)) < n), false)


def test_a_detector_that_finds_nothing_is_refused() -> None:
    looks, false = made()
    with pytest.raises(DataError, match="0 found"):
        fit_errors("made", dataclasses.replace(looks, found=np.zeros(len(looks.name), bool)), false)


@pytest.fixture(scope="module")
def walks() -> dict[str, tuple[Looks, FalseBoxes]]:
    episodes = load_episodes("mini", "paper")[:8]
    return {name: collect(NoisyDetector(rates), episodes) for name, rates in (("exact", EXACT), ("noisy", Rates()))}


def test_exact_boxes_are_matched_with_their_things(walks: dict[str, tuple[Looks, FalseBoxes]]) -> None:
    looks, false = walks["exact"]
    assert len(looks.name) > 2000
    seen = looks.pixels >= MIN_PIXELS
    assert looks.found[seen].mean() > 0.99
    assert not looks.found[~seen].any(), "looks at what is too small are in vain"
    hits = looks.keep(looks.found)
    assert (hits.called == hits.name).mean() > 0.99
    assert len(false.score) == 0


def test_a_walk_shows_the_rates_of_a_simulated_detector(walks: dict[str, tuple[Looks, FalseBoxes]]) -> None:
    errors = fit_errors("noisy", *walks["noisy"])
    assert errors.right == pytest.approx(0.8, abs=0.06)
    assert errors.false_boxes == pytest.approx(0.3, abs=0.12)
    assert (errors.sides, errors.octave) == (8, 1.0)
    assert errors.repeats > 0.6
    assert errors.repeats_elsewhere < 0.15
    assert errors.evidence(0.9) > 1.0 > -0.5 > errors.evidence(0.4)


def test_the_command_fits_shows_and_draws(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    file, plots = tmp_path / "errors.json", tmp_path / "plots"
    words = ["detector", "fit", "noisy", str(file), "detector.seed=3", "--episodes", "mini", "--walks", "6"]
    words += ["--plots", str(plots)]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "expected calibration error" in said
    names = {"recall.png", "scores.png", "confusions.png", "reliability.png"}
    assert {path.name for path in plots.iterdir()} == names
    for path in plots.iterdir():
        assert len(np.unique(np.asarray(Image.open(path)))) > 20, "something is drawn"
    assert main(["detector", "show", "noisy", "--plots", str(tmp_path / "shown")]) == 0
    assert {path.name for path in (tmp_path / "shown").iterdir()} == names - {"reliability.png"}
    assert max(map(len, said.replace(str(tmp_path), "").splitlines())) <= 80
    assert main(["detector", "show", "noisy", str(file), "--thing", "laptop"]) == 0
    assert "laptop" in capsys.readouterr().out
    assert main(["detector", "show", "noisy", str(file), "--thing", "laptob"]) == 2
    assert "laptop" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["fit", "gt", "FILE"],
        ["fit", "nois", "FILE"],
        ["fit", "noisy", "FILE", "--walks", "0"],
        ["fit", "noisy", "FILE", "--walks", "2", "--episodes", "mini", "detector.sed=1"],
        ["fit", "noisy", "FILE", "--episodes", "nowhere"],
        ["show", "owlv2"],
    ],
)
def test_what_cannot_be_is_one_line(words: list[str], tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["detector", *(str(tmp_path / "x.json") if word == "FILE" else word for word in words)]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
