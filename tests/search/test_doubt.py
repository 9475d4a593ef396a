"""Searches with uncertain detections: suspects, Done, giving up, and searches without any detection."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy

import numpy as np
import pytest

from ucon.core.errors import ConfigError, DetectorError
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.noise_rates import EXACT
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.places.containers import Containers
from ucon.search.doubt import Doubts
from ucon.search.searcher import Searcher
from ucon.search.suspects import EVIDENCE, arithmetic
from ucon.task.actions import Action

Judge = Callable[[np.ndarray], np.ndarray]


def played(detector: BoxDetector, number: int = 0, judge: Judge | None = None, doubts: Doubts | None = None) -> dict:
    """Search by coverage to the end, and return what happened."""
    env = UcONEnv("mini", observe="symbolic", detector=detector, habit_level="none")
    observation, info = env.reset(options={"episode": number})
    search = Searcher(info, Coverage(str(info["target"]), CoverageWeights()), judge=judge, doubts=doubts)
    actions, p, over = [], [], False
    while not over:
        action = search.look(observation, info)
        assert search.doubt is not None
        p.append(dict(search.doubt.p))
        if action is None:
            action = search.choose(search.decision().best)
        actions.append(int(action))
        observation, _, done, truncated, info = env.step(int(action))
        over = done or truncated
    env.close()
    return {"actions": actions, "p": p, "success": info["is_success"], "search": search}


class Blind(BoxDetector):
    """A detector that never finds anything."""

    name, needs_rgb = "noisy", False

    def find(self, frame: Frame) -> Boxes:
        return Boxes.none()


class Broken(Blind):
    """A detector that always reports one box with a given score and left edge."""

    def __init__(self, score: float, left: float) -> None:
        super().__init__()
        self._box = np.array([score], np.float32), np.array([[left, 40, 60, 60]], np.float32)

    def find(self, frame: Frame) -> Boxes:
        return Boxes(["mug"], *self._box)


def test_a_search_finds_by_exact_boxes_and_is_sure_at_the_end() -> None:
    found = [played(NoisyDetector(EXACT), number) for number in range(3)]
    assert sum(run["success"] for run in found) >= 2
    for run in found:
        if run["success"]:
            assert max(run["p"][-1].values()) > 0.7


def test_a_search_repeats_itself() -> None:
    first, second = (played(NoisyDetector(), 1) for _ in range(2))
    assert first["actions"] == second["actions"]
    assert first["p"] == second["p"]


def test_without_any_detection_the_search_goes_on_and_never_says_done() -> None:
    run = played(Blind(), 0)
    assert len(run["actions"]) == 300
    assert Action.DONE not in run["actions"]
    moved = {(view.i, view.j) for view in run["search"].map.views}
    assert len(moved) > 20


@pytest.mark.parametrize(("score", "left"), [(np.nan, 40.0), (1.5, 40.0), (-0.1, 40.0), (0.5, np.nan)])
def test_boxes_that_no_detector_may_report_are_refused_in_one_line(score: float, left: float) -> None:
    with pytest.raises(DetectorError, match=r"^detector noisy: .*mug.*number[^\n]*$"):
        played(Broken(score, left), 0)


def test_a_detector_whose_errors_are_unknown_is_refused_in_one_line() -> None:
    unknown = NoisyDetector(name="my_own")
    with pytest.raises(ConfigError, match=r"^detector my_own: .*python -m ucon detector fit my_own FILE[^\n]*$"):
        played(unknown, 0)


def test_a_judge_that_never_believes_keeps_the_search_from_done() -> None:
    run = played(NoisyDetector(), 0, judge=lambda evidence: np.zeros(len(evidence)))
    assert Action.DONE not in run["actions"]


def test_a_judge_that_believes_anything_ends_early() -> None:
    trusting = played(NoisyDetector(), 0, judge=lambda evidence: np.ones(len(evidence)))
    assert Action.DONE in trusting["actions"]
    careful = played(NoisyDetector(), 0)
    assert len(trusting["actions"]) < len(careful["actions"])


def test_near_the_end_the_best_suspect_is_taken() -> None:
    """No suspect is ever certain enough, but at the end each is worth a try."""
    judge, never = (lambda evidence: np.full(len(evidence), 0.3)), Doubts(consider=1.0, take=1.0, settle=1.0)
    runs = [played(NoisyDetector(), number, judge, never) for number in range(3)]
    assert any(run["actions"][-1] == Action.DONE and len(run["actions"]) > 270 for run in runs)
    kept = Doubts(consider=1.0, take=1.0, settle=1.0, last_least=0.5)
    assert Action.DONE not in played(NoisyDetector(), 0, judge, kept)["actions"]


def test_evidence_is_finite_and_the_posterior_grows_with_the_place() -> None:
    run = played(NoisyDetector(), 2)
    evidence = run["search"].doubt.suspects.evidence
    assert np.isfinite(evidence).all()
    rows = np.zeros((2, len(EVIDENCE)), np.float32)
    rows[1, EVIDENCE.index("ratio")] = 2.0
    low, high = arithmetic(rows)
    assert low == pytest.approx(0.5)
    assert high == pytest.approx(1.0 / (1.0 + np.exp(-2.0)))


def test_all_that_depends_on_names_follows_when_names_change() -> None:
    """Places, coverage and containers that are updated step by step equal those computed from the final map."""
    search = played(NoisyDetector(), 1)["search"]
    known, n = search.map, search.map.n_tracks
    assert (known.named_at[:n] > 0).sum() > 5, "names came and changed"
    by_name: dict[str, list[int]] = {}
    for track, name in enumerate(known.category):
        if name:
            by_name.setdefault(name, []).append(track)
    assert {name: sorted(tracks) for name, tracks in known.instances.items()} == by_name
    search.expect()
    fresh = Coverage(search.target, CoverageWeights()).expect(known, search.places)
    assert (search.expected.mass == fresh.mass).all()
    assert (search.closed() == Containers().closed(known)).all()
    share = np.bincount(search.places.track, search.places.share, n)
    nameless = [track for track in range(n) if not known.category[track]]
    assert not share[nameless].any(), "what is no thing after all holds nothing"


def test_hypotheses_are_copied_with_the_search() -> None:
    env = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="none")
    observation, info = env.reset(options={"episode": 0})
    search = Searcher(info, Coverage(str(info["target"]), CoverageWeights()))
    for _ in range(5):
        search.look(observation, info)
        observation, *_, info = env.step(Action.ROTATE_LEFT)
    copy = deepcopy(search)
    before = search.map.hypotheses.p_target.copy(), dict(search.map.hypotheses.looks)
    for action in (Action.MOVE_AHEAD, Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.MOVE_AHEAD):
        copy.look(observation, info)
        observation, *_, info = env.step(action)
    assert (search.map.hypotheses.p_target[: len(before[0])] == before[0]).all()
    assert {track: len(looks) for track, looks in search.map.hypotheses.looks.items()} == {
        track: len(looks) for track, looks in before[1].items()
    }
    assert copy.map.hypotheses.errors is search.map.hypotheses.errors
    env.close()


def test_nothing_is_learned_from_looking_in_vain_where_that_is_switched_off() -> None:
    env = UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), habit_level="none")
    least = {}
    for miss in (0.1, 1.0):
        observation, info = env.reset(options={"episode": 0})
        search = Searcher(info, Coverage(str(info["target"]), CoverageWeights()), miss=miss)
        for _ in range(4):
            search.observe(observation, info)
            observation, *_, info = env.step(Action.ROTATE_LEFT)
        least[miss] = search.places.unseen[search.places.share > 0.0].min()
    env.close()
    assert least[1.0] == 1.0
    assert least[0.1] < 0.9
