import pytest

from ucon.core.rng import stream
from ucon.evaluation.datasets.agreement import alpha_interval, krippendorff_alpha

#: Four observers, twelve units, five values: the worked example of Krippendorff (2011), "Computing Krippendorff's
#: alpha-reliability", with values from 0.
EXAMPLE = [
    [0, 0, 0],
    [1, 1, 2, 1],
    [2, 2, 2, 2],
    [2, 2, 2, 2],
    [1, 1, 1, 1],
    [0, 1, 2, 3],
    [3, 3, 3, 3],
    [0, 0, 1, 0],
    [1, 1, 1, 1],
    [4, 4, 4],
    [0, 0],
    [2],
]


@pytest.mark.parametrize(("scale", "alpha"), [("nominal", 0.743), ("ordinal", 0.815)])
def test_worked_example(scale, alpha):
    assert krippendorff_alpha(EXAMPLE, 5, scale) == pytest.approx(alpha, abs=5e-4)


def test_perfect_chance_and_undefined():
    assert krippendorff_alpha([[0, 0], [1, 1], [2, 2]], 3, "nominal") == 1.0
    noise = stream(0, "noise").integers(3, size=(4000, 3))
    assert krippendorff_alpha(noise.tolist(), 3, "ordinal") == pytest.approx(0.0, abs=0.03)
    assert krippendorff_alpha([[1], [2]], 3, "nominal") is None, "one rater"
    assert krippendorff_alpha([[1, 1], [1, 1]], 3, "nominal") is None, "one value"
    assert alpha_interval([], 3, "nominal") is None


def test_interval_holds_alpha_and_is_the_same_twice():
    interval = alpha_interval(EXAMPLE, 5, "nominal")
    assert interval == alpha_interval(EXAMPLE, 5, "nominal")
    assert interval is not None
    assert interval.low < interval.mean < interval.high <= 1.0
    assert interval.n == 11
