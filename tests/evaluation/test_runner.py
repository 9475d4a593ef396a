"""The runner with the real environment: records depend only on the episode; failures reach the user."""

import json
from dataclasses import replace
from functools import partial

import pytest

from models.agents.oracle import OracleAgent
from tests.evaluation.random_runs import lines, random_run, six_episodes
from ucon.core.errors import ConfigError
from ucon.evaluation.kept.record import EpisodeRecord, episode_spl
from ucon.evaluation.playing.pictures import worth_filming
from ucon.evaluation.playing.runner import evaluate, resolve_workers


@pytest.fixture(scope="module")
def episodes():
    return six_episodes()


@pytest.fixture(scope="module")
def spec():
    return random_run()


@pytest.fixture(scope="module")
def alone(spec, episodes):
    return lines(evaluate(spec, episodes, workers=0))


def test_workers_change_no_record(spec, episodes, alone):
    assert lines(evaluate(spec, episodes, workers=3)) == alone


def test_order_and_batch_change_no_record(spec, episodes, alone):
    assert lines(evaluate(spec, episodes[::-1], workers=0)) == alone
    assert lines(evaluate(replace(spec, batch=4), episodes, workers=0)) == alone


def test_shards_change_no_record(spec, episodes, alone):
    shards = [evaluate(spec, episodes[k::2], workers=0) for k in range(2)]
    assert lines(shards[0] + shards[1]) == alone


def test_skipped_episodes_are_not_played_again(spec, episodes):
    seen = []
    played = evaluate(spec, episodes, workers=0, skip=[0, 2, 3], on_played=lambda p: seen.append(p.index))
    assert [p.index for p in played] == [1, 4, 5] == sorted(seen)


def test_records_are_consistent_with_themselves(spec, episodes):
    for played, episode in zip(evaluate(spec, episodes, workers=0), episodes, strict=True):
        r = played.record
        assert r.episode == episode.id
        assert len(r.actions) == r.steps <= 300
        assert r.opens == r.actions.count("5")
        assert r.path_length_m == 0.25 * (r.actions.count("0") - r.collisions)
        assert r.spl == pytest.approx(episode_spl(r.success, r.shortest_path_m, r.path_length_m), abs=1e-5)
        assert EpisodeRecord.from_json(json.loads(r.to_line())) == r
        assert (r.failure_cause == "none") == r.success
        assert r.success or r.first_seen_step < 0 or r.failure_cause != "never_seen"
        assert 0 <= r.recall_10 <= r.recall_20 <= 1
        assert 0 < r.mrr <= 1


def test_the_stored_solution_scores_full_marks(spec, episodes):
    for played in evaluate(replace(spec, agent=OracleAgent), episodes, workers=0):
        assert played.record.success, played.record
        assert played.record.spl == pytest.approx(1.0)


def test_pictures_of_the_first_episodes(spec, episodes, tmp_path):
    env = partial(spec.env, render_mode="rgb_array")
    filmed = replace(spec, agent=OracleAgent, env=env, films=tmp_path)
    evaluate(filmed, episodes[:1], workers=0)
    assert sorted(p.suffix for p in tmp_path.iterdir()) == [".png", ".webm"]
    assert all(p.stat().st_size > 1000 for p in tmp_path.iterdir())


@pytest.mark.parametrize(
    ("found", "n", "chosen"),
    [("YYNYNNY", 2, [0, 1, 2, 4]), ("YYY", 2, [0, 1]), ("N", 1, [0]), ("", 2, []), ("YN", 0, [])],
)
def test_both_endings_are_worth_a_film(found, n, chosen):
    assert worth_filming([letter == "Y" for letter in found], n) == chosen


@pytest.mark.parametrize(
    ("asked", "episodes_left", "expected"), [("auto", 1, 1), (0, 9, 0), (3, 9, 3), ("3", 2, 2), (8, 0, 0)]
)
def test_number_of_workers(asked, episodes_left, expected):
    assert resolve_workers(asked, episodes_left) == expected


@pytest.mark.parametrize("asked", ["many", -1, "1.5"])
def test_bad_number_of_workers(asked):
    with pytest.raises(ConfigError, match="workers="):
        resolve_workers(asked, 5)
