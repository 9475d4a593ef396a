"""Measuring beliefs: exact figures, and the alarm for readers that know too much."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.evaluation.beliefs import ORACLE, measure_beliefs
from ucon.habits import book
from ucon.objects.model import RELATIONS
from ucon.readers import AnchorReader
from ucon.readers.anchor_reader import AnchorBelief
from ucon.readers.belief_scores import calibration_error, scores
from ucon.readers.sampled_homes import location_distribution, sampled_kb
from ucon.retrieval import DenseRetriever


@pytest.fixture(scope="module")
def kbs():
    return [sampled_kb(book(), "test", 7, "task", k=6)]


class Cheat:
    """A reader that is given the true distribution and sharpens it."""

    def __init__(self, kb):
        self.kb = kb

    def read(self, target, texts, *, trusted=False):
        return SimpleNamespace(belief=partial(self.belief, target))

    def belief(self, target, candidates):
        truth = location_distribution(self.kb.entries[target])
        (anchor, _), _ = max(truth.items(), key=lambda item: item[1])
        p = np.asarray([sum(v for (a, _), v in truth.items() if a == name) for name in candidates])
        p = p + 0.0 * (np.asarray(candidates) == anchor)
        relation = np.asarray([[float((n, r) in truth) for r in RELATIONS] for n in candidates]) + 1e-9
        return AnchorBelief(tuple(candidates), p**2 + p, relation / relation.sum(1, keepdims=True), 0.0, {})


def measured(reader, kbs, levels=("none", "gt")):
    return measure_beliefs(kbs, reader, DenseRetriever(), lambda _: book().anchors, levels=levels)


def test_the_oracle_is_above_every_level(kbs):
    found = measured(AnchorReader(), kbs)
    best = {name: np.mean(values) for name, values in found[ORACLE].values.items()}
    assert best["hit_at_5"] == pytest.approx(1)
    for level in ("none", "gt"):
        assert np.mean(found[level].values["nll"]) > best["nll"]
        assert len(found[level].clusters) == 6
    assert found["gt"].intervals()["hit_at_5"].low <= np.mean(found["gt"].values["hit_at_5"])


def test_knowing_the_places_is_no_leak_knowing_the_draw_is(kbs):
    from ucon.evaluation import beliefs

    found = measured(Cheat(kbs[0]), kbs)
    drawn = dict(found)
    drawn["gt"].values["nll"] = [value - 0.5 for value in found[ORACLE].values["nll"]]
    with pytest.raises(DataError, match="leaks into what is read"):
        beliefs._alarm(drawn)


def test_no_target_is_an_error(kbs):
    with pytest.raises(DataError, match="no target"):
        measure_beliefs(kbs, AnchorReader(), DenseRetriever(), lambda _: book().anchors, lambda _: False)


def test_scores_by_hand():
    y = np.zeros((3, 4))
    y[0, 0], y[2, 1] = 0.25, 0.75
    relation = np.full((3, 4), 0.1)
    relation[:, 0] = 0.7
    found = scores(np.asarray([0.5, 0.3, 0.2]), relation, y)
    assert found["hit_at_1"] == 0.25
    assert found["visits"] == 0.25 + 3 * 0.75
    assert found["nll"] == pytest.approx(-0.25 * np.log(0.5) - 0.75 * np.log(0.2))
    assert found["relation"] == 0.25


def test_calibration_error_by_hand():
    p, y = np.asarray([0.1, 0.1, 0.9]), np.asarray([0.0, 0.2, 0.6])
    assert calibration_error(p, y) == pytest.approx(0.1)


def test_hits_are_counted_up_to_the_one_named():
    """Seven places, with the truth spread over the places ranked first, fifth and sixth."""
    y = np.zeros((7, 4))
    y[0, 0], y[4, 0], y[5, 0] = 0.5, 0.3, 0.2
    found = scores(np.linspace(0.4, 0.1, 7), np.full((7, 4), 0.25), y)
    assert found["hit_at_1"] == 0.5
    assert found["hit_at_5"] == 0.8
