"""``python -m ucon report`` of runs over lives: the file's content matches the records and lives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.records import record
from tests.lives.short import short_life
from tests.pages.lives import DAYS, EACH, two_lives
from tests.pages.report.test_report import values_of
from ucon.__main__ import main
from ucon.evaluation.figures.lives_table import grouped
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.kept.record import EpisodeRecord, read_records
from ucon.evaluation.kept_memories import NEAR_M, Truth
from ucon.lives.clock import day_and_slot
from ucon.lives.request_record import BelievedPlace, LifeFacts
from ucon.lives.sets import load_lives
from ucon.lives.timeline import Timeline
from ucon.pages.report.life_records import curves_of, rows_by_life
from ucon.pages.report.life_story import LifeStory, held
from ucon.task.spoken import spoken_place


def of_life(life: str, request: int, day: int, spl: float) -> EpisodeRecord:
    facts = LifeFacts(life, request, day, 0, None, None, obeys=True, changed=False)
    return replace(record(request), episode=f"{life}/{request}", life=facts, success=spl > 0, spl=spl)


def test_figures_are_those_of_the_runs(life_report: Path, life_runs: tuple[Path, Path]) -> None:
    index, records = values_of(life_report, "index"), [read_records(folder) for folder in life_runs]
    for k, (told, some) in enumerate(zip(index["runs"], records, strict=True)):
        assert told["figures"]["n"] == 2 * EACH
        assert told["figures"]["sr"][0] == pytest.approx(np.mean([r.success for r in some]), abs=1e-4)
        expected = [(name, len(part), np.mean([r.spl for r in part])) for name, part in grouped(some)]
        groups = {group["name"]: group["runs"][k] for group in index["groups"]}
        assert len(expected) > 4
        for name, n, spl in expected:
            assert groups[name]["n"] == n
            assert groups[name]["spl"][0] == pytest.approx(spl, abs=1e-4)
    (pair,) = index["differences"]
    expected_pair = compare_records(records[1], records[0]).differences["spl"]
    assert (pair["first"], pair["n"]) == (1, 2 * EACH)
    assert pair["spl"] == pytest.approx([expected_pair.mean, *expected_pair.ci95], abs=1e-4)


def test_curves_average_over_lives_not_over_requests() -> None:
    records = [of_life("a", 0, 0, 1.0), of_life("a", 1, 0, 0.0), of_life("a", 2, 0, 0.5), of_life("b", 0, 0, 0.1)]
    curves = curves_of([*records, of_life("b", 1, 4, 0.3)])
    (day, mean, low, high), alone = curves["spl"]
    assert (day, mean, low, high) == (1, pytest.approx(0.3), pytest.approx(0.1), pytest.approx(0.5))
    assert alone == [5, 0.3, None, None]  # a single life has no interval over lives
    assert [point[1] for point in curves["sr"]] == [pytest.approx((2 / 3 + 1) / 2, abs=1e-4), 1.0]


def test_requests_are_in_order_whatever_the_order_of_records() -> None:
    records = [of_life("b", 1, 1, 0.5), of_life("a", 0, 0, 0.25), of_life("b", 0, 0, 0.0), record(9)]
    found = rows_by_life(records)
    assert {life: [row["request"] for row in rows] for life, rows in found.items()} == {"b": [0, 1], "a": [0]}
    assert (found["b"][0]["found"], found["b"][1]["spl"]) == (False, 0.5)


def test_a_life_is_told_as_it_was(life_report: Path, life_runs: tuple[Path, Path]) -> None:
    heads = values_of(life_report, "index")["lives"]
    for number, life in enumerate(two_lives()):
        assert (heads[number]["id"], heads[number]["days"], heads[number]["change"]) == (life.id, DAYS, DAYS - 1)
        told, at = values_of(life_report, f"life-{number}"), Timeline(life).at
        for k, thing in enumerate(told["things"]):
            changes = dict(thing["at"])
            place, found = -1, []
            for time in range(len(at)):
                place = changes.get(time, place)
                found.append(place)
            assert found == at[:, k].tolist()
            assert thing["name"] == life.possessions[k].category
        for folder, rows in zip(life_runs, told["runs"], strict=True):
            mine = [r for r in read_records(folder) if r.life is not None and r.life.life == life.id]
            asked = [(*day_and_slot(one.time), life.possessions[one.possession].category) for one in life.requests]
            assert [(row["day"], row["slot"], row["target"]) for row in rows] == asked
            assert [row["user"] for row in rows] == [one.user for one in life.requests]
            assert [(row["found"], row["steps"]) for row in rows] == [(r.success, r.steps) for r in mine]


def test_beliefs_stand_in_the_row_of_the_nearest_place(life_report: Path, life_runs: tuple[Path, Path]) -> None:
    n_held = 0
    for number, life in enumerate(two_lives()):
        truth, told = Truth.of(life), values_of(life_report, f"life-{number}")
        names = [one.category for one in life.possessions]
        mine = [r for r in read_records(life_runs[0]) if r.life is not None and r.life.life == life.id]
        for one, row in zip(mine, told["runs"][0], strict=True):
            assert one.believed is not None
            for place, (at, p, words) in zip(one.believed, row["believed"], strict=True):
                n_held += 1
                assert (p, words) == (pytest.approx(place.p, abs=1e-3), place.words)
                away = [np.hypot(np.hypot(x - place.x, y - place.y), z - place.z)
                        for x, y, z in truth.xyz[names.index(one.target)]]  # fmt: skip
                assert at == (int(np.argmin(away)) if min(away) <= NEAR_M else -1)
        assert all("believed" not in row for row in told["runs"][1])  # it has no memory
    assert n_held > 0


def test_a_belief_far_from_all_places_is_elsewhere() -> None:
    places = np.array([[0.0, 0.0, 0.5], [2.0, 0.0, 0.5]])
    believed = [BelievedPlace("on the desk", 0.5, 1.5, 0.1, 0.6), BelievedPlace("", 0.25, 1.0, 0.0, 0.5)]
    assert held(believed, places) == [[1, 0.5, "on the desk"], [-1, 0.25, ""]]


def test_places_of_a_thing_have_words_of_their_own() -> None:
    alike = 0
    for life in (short_life(1), *load_lives("lives_mini")):
        story = LifeStory(Truth.of(life))
        for k, spots in enumerate(story.truth.spots):
            words = story.words(k)
            assert len(set(words)) == len(words) == len(spots)
            assert all(text.startswith(spoken_place(*spot)) for text, spot in zip(words, spots, strict=True))
            alike += len(set(spots)) < len(spots)
    assert alike > 0  # some places differ only by room or number


def test_the_same_again_and_beside_the_run(life_runs: tuple[Path, Path]) -> None:
    assert main(["report", str(life_runs[1])]) == 0
    first = (life_runs[1] / "report.html").read_bytes()
    assert main(["report", str(life_runs[1])]) == 0
    assert (life_runs[1] / "report.html").read_bytes() == first
    assert main(["verify", str(life_runs[1])]) == 0


def test_lives_and_episodes_have_reports_of_their_own(
    life_runs: tuple[Path, Path], runs: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "report.html"
    assert main(["report", str(runs[0]), str(life_runs[0]), "--out", str(out)]) == 2
    assert main(["report", str(life_runs[0]), "--pictures", "all", "--out", str(out)]) == 2
    mixed, pictures = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert str(life_runs[0]) in mixed
    assert "a report of each kind" in mixed
    assert "--pictures all" in pictures
    assert not out.exists()
