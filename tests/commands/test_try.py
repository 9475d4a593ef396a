"""``python -m ucon try``: the user's own habits, from the command line to two searches."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from tests.evaluation.records import record
from ucon.__main__ import main
from ucon.commands.try_ import _given_lines
from ucon.evaluation.kept.record import read_records
from ucon.habits.datafile import load_dataset_file
from ucon.programs.two_searches import Search, print_searches
from ucon.task.making.own_household import FaultsError, OwnPlacement, likely_places
from ucon.task.sets import load_episodes

ASIDE = "On Sundays the family walks to the lake and feeds the ducks."
SAID = "After the morning mails the blue mug stays beside the laptop."


def test_own_habits_and_the_search_by_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["try", "--object", "mug", "--habit", SAID, "--habit", ASIDE, "--no-video", "--out", str(tmp_path / "own")]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "mug in Rs_int: kept beside the laptop, as read from your habits (" in told
    assert f'  number 1 of 20 retrieved: "{SAID}"\n  not among the 20 retrieved: "{ASIDE}"\n\n' in told
    (episode,) = load_episodes(str(tmp_path / "own" / "own.jsonl.xz"))
    entry = load_dataset_file(tmp_path / "own" / "own.habits.xz").entries[0]
    assert [habit.text for habit in entry.habits] == [SAID, ASIDE]
    assert episode.placed_by[episode.target] == (entry.id, 0)
    for level in ("none", "retrieval"):
        (record,) = read_records(tmp_path / "own" / level)
        assert (record.habit_level, record.target, record.relation) == (level, "mug", "nextto")
        assert f"{record.steps:>8}" in told
    assert main(words) == 0, "again, beside what is there"


def test_where_nothing_is_ranked_the_sentences_are_given_or_not(capsys: pytest.CaptureFixture[str]) -> None:
    def lines(given: tuple[str, ...] | None, level: str) -> list[str]:
        return [*_given_lines([SAID], Search(Path(), record(0, habit_level=level), given, ""))]

    assert lines((ASIDE, SAID), "gt") == [f'  one of 2 given: "{SAID}"']
    assert lines((), "none") == [f'  not given at level none: "{SAID}"']
    assert lines(None, "retrieval") == ["agent belief reads no habits"]


def test_a_lost_search_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found, lost = record(0), record(0, success=False, habit_level="none")
    print_searches([Search(tmp_path, lost, (), "never seen; steps ran out at 300"), Search(tmp_path, found, (), "")])
    assert capsys.readouterr().out.splitlines()[3:] == ["none: never seen; steps ran out at 300"]


def test_a_place_is_taken_as_it_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["try", "--object", "mug", "--habit", SAID, "--place", "ontop:bed", "--no-video", "--out", str(tmp_path)]
    assert main(words) == 0
    assert "mug in Rs_int: kept on the bed\n" in capsys.readouterr().out


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--scene", "Rs_in", "--object", "mugg", "--habit", "", "--habit", "x" * 401, "--place", "beside:laptop"]
    assert main(["try", *words, "--out", str(tmp_path / "own")]) == 2
    told = capsys.readouterr().err.splitlines()
    parts = (
        "--scene: unknown scene 'Rs_in': did you mean Rs_int",
        "--object: unknown object 'mugg': did you mean",
        "--habit, number 1: 0 words, expected 1 to 80",
        "--habit, number 2: 401 characters, at most 400",
        "--place beside:laptop: unknown relation 'beside'",
    )
    for line, part in zip(told, parts, strict=True):
        assert line.startswith(f"error: {part}")
    assert not (tmp_path / "own").exists()


@pytest.mark.parametrize(
    ("place", "part"),
    [("laptop", "expected RELATION:ANCHOR"), ("inside:laptop", "nothing is inside a laptop"), ("ontop:mug", "mug")],
)
def test_places_that_are_none(place: str, part: str) -> None:
    with pytest.raises(FaultsError, match=part):
        OwnPlacement.of("Rs_int", "mug", [SAID], place)


def test_what_takes_no_such_thing_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["try", "--object", "bicycle", "--habit", SAID, "--place", "inside:microwave", "--out", str(tmp_path)]
    assert main(words) == 2
    assert "Rs_int: a bicycle cannot be kept in the microwave there" in capsys.readouterr().err


def test_places_are_those_that_stand_there_the_likeliest_first() -> None:
    names = ("laptop", "swimming_pool", "bed")
    p = np.array([[0.01, 0.0, 0.0, 0.2], [0.9, 0.9, 0.9, 0.9], [0.3, 0.0, 0.05, 0.0]])
    places = likely_places(OwnPlacement.of("Rs_int", "mug", [SAID], None), lambda *_: (names, p))
    assert [(place.relation, place.anchor) for place, _ in places[:3]] == [
        ("ontop", "bed"),
        ("nextto", "laptop"),
        ("under", "bed"),
    ]
    assert [chance for _, chance in places[:3]] == [0.3, 0.2, 0.05]


def test_the_demo_shows_the_point(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--no-video", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    without, with_habits = (read_records(tmp_path / level)[0] for level in ("none", "retrieval"))
    assert not without.success
    assert with_habits.success
    assert with_habits.steps < 100
    assert "first aid kit" in told
    assert "top cabinet" in told
    assert all(len(line) <= 110 for line in told.splitlines())


def test_a_book_of_ones_own_is_placed_where_a_home_can_hold_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "own_household.md").read_text()
    book = page[page.index("    # mug |") : page.index("A number says which")]
    (tmp_path / "book").mkdir()
    (tmp_path / "book" / "things.txt").write_text(dedent(book))
    words = ["episodes", "make", "mini", "--habits", str(tmp_path / "book"), "--limit", "2"]
    told, made = [], []
    for workers in ("1", "2"):
        out = tmp_path / f"by_{workers}.jsonl.xz"
        assert main([*words, "--workers", workers, "--out", str(out)]) == 0
        told.append([line for line in capsys.readouterr().err.splitlines() if "left out" in line])
        made.append(out.read_bytes())
    assert made[0] == made[1]
    assert told[0] == told[1]
    assert "left out, no target of dataset" in told[0][0]
    assert len(load_episodes(tmp_path / "by_2.jsonl.xz")) == 2


def test_sentences_that_say_no_place_are_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["try", "--object", "mug", "--habit", "I like the sea.", "--no-video", "--out", str(tmp_path / "own")]
    assert main(words) == 0
    assert "warning: your sentences hardly say where it is; give --place" in capsys.readouterr().err
