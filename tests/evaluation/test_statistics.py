import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.evaluation.figures.intervals import mean_interval, paired_difference, rate_interval


def test_interval_of_a_known_sample():
    values = np.arange(100) / 99
    interval = mean_interval(values)
    half = 1.96 * values.std() / 10
    assert interval.mean == pytest.approx(0.5)
    assert interval.low == pytest.approx(0.5 - half, abs=0.005)
    assert interval.high == pytest.approx(0.5 + half, abs=0.005)
    assert interval.n == 100


def test_same_data_same_interval_other_seed_another():
    values = stream(3, "values").random(60)
    assert mean_interval(values) == mean_interval(values)
    assert mean_interval(values, seed=1) != mean_interval(values, seed=2)


def test_constant_values_have_no_spread():
    assert mean_interval([0.25] * 7).ci95 == (0.25, 0.25)


@pytest.mark.parametrize(("successes", "low", "high"), [([True] * 20, 0.8389, 1.0), ([False] * 20, 0.0, 0.1611)])
def test_all_equal_rates_get_wilsons_interval(successes, low, high):
    interval = rate_interval(successes)
    assert interval.low == pytest.approx(low, abs=1e-4)
    assert interval.high == pytest.approx(high, abs=1e-4)


def test_rate_in_between_is_bootstrapped():
    successes = [True] * 30 + [False] * 70
    assert rate_interval(successes) == mean_interval(successes)


@pytest.mark.parametrize("probability", [0.3, 0.8])
def test_coverage_of_the_bootstrap(probability):
    rng = stream(11, "coverage", str(probability))
    samples = (rng.random((300, 120)) < probability).astype(float)
    intervals = [mean_interval(sample, resamples=1000) for sample in samples]
    covered = np.mean([i.low <= probability <= i.high for i in intervals])
    assert 0.91 <= covered <= 0.985


def test_clusters_widen_the_interval_and_cover_where_episodes_alone_do_not():
    rng = stream(5, "clusters")
    alone, by_home = [], []
    for _ in range(200):
        effects = rng.normal(0, 1, 15)
        values = np.repeat(effects, 20) + rng.normal(0, 0.3, 300)
        names = [f"home{i // 20}" for i in range(300)]
        a, b = mean_interval(values, resamples=500), mean_interval(values, clusters=names, resamples=500)
        alone.append(a.low <= 0 <= a.high)
        by_home.append(b.low <= 0 <= b.high)
    assert np.mean(alone) < 0.5
    assert np.mean(by_home) > 0.86


def test_pairing_finds_what_the_single_intervals_hide():
    difficulty = stream(2, "difficulty").random(200)
    better, worse = difficulty + 0.02, difficulty
    difference = paired_difference(better, worse)
    assert difference.mean == pytest.approx(0.02)
    assert difference.excludes_zero
    assert mean_interval(better).low < mean_interval(worse).high


def test_no_difference_includes_zero():
    rng = stream(8, "null")
    assert not paired_difference(rng.random(400), rng.random(400)).excludes_zero


@pytest.mark.parametrize(
    ("values", "message"),
    [([], "at least one value"), ([1.0, float("nan")], "not finite"), ([[1.0], [2.0]], "shape")],
)
def test_bad_values_are_refused(values, message):
    with pytest.raises(ConfigError, match=message):
        mean_interval(values)


def test_unequal_pairs_and_clusters_are_refused():
    with pytest.raises(ConfigError, match="same episodes"):
        paired_difference([1.0, 2.0], [1.0])
    with pytest.raises(ConfigError, match="one each"):
        mean_interval([1.0, 2.0], clusters=["a"])
