"""``habits show`` and ``habits survey`` as a user runs them, but in this process."""

import json

import pytest

from tests.habits.test_book import GOOD
from ucon.__main__ import main
from ucon.habits import book


def said(capsys, *words: str) -> str:
    assert main(["habits", *words]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def test_a_category_is_shown_whole_and_plain_when_piped(capsys):
    out = said(capsys, "show", "mug")
    assert "\x1b" not in out
    lines = [line.strip() for line in out.splitlines()]
    for entry in book().entries_of("mug"):
        assert any(entry.id in line and entry.household in line for line in lines)
        for number, place in enumerate(entry.placements, 1):
            context = f" {{{place.context}}}" if place.context else ""
            assert any(line.startswith(f"@{number} {place.relation} {place.anchor}{context}") for line in lines)
        for habit in entry.habits:
            mark = ",".join(str(i + 1) for i in habit.supports) or "-"
            assert f"{mark}: {habit.text}" in lines


def test_a_category_as_json(capsys):
    shown = json.loads(said(capsys, "show", "mug", "--json"))
    entry = book().entries_of("mug")[0]
    assert shown["entries"][0]["habits"][0] == {
        "text": entry.habits[0].text,
        "supports": [i + 1 for i in entry.habits[0].supports],
    }
    assert {one["part"] for one in shown["entries"]} <= {"train", "val", "test"}


def test_a_scene_says_who_lives_there_and_why_not(capsys):
    out = said(capsys, "show", "Rs_int")
    assert "categories may be targets" in out
    assert "not here: absent_anchor" in out
    shown = json.loads(said(capsys, "show", "Rs_int", "--json"))
    places = [p for row in shown["categories"] for entry in row["entries"] for p in entry["placements"]]
    assert all((place["reason"] is None) == place["realisable"] for place in places)
    assert json.loads(said(capsys, "show", "Rs_int", "--seed", "1", "--json"))["categories"] != shown["categories"]


def test_one_category_of_a_scene_comes_with_its_habits(capsys):
    out = said(capsys, "show", "Rs_int", "--category", "mug")
    shown = json.loads(said(capsys, "show", "Rs_int", "--category", "mug", "--json"))
    (row,) = shown["categories"]
    assert row["entries"][0]["habits"][0]["text"] in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["show", "mugg"], "unknown category or scene 'mugg': did you mean mug"),
        (["show", "Rs_imt"], "did you mean Rs_int"),
        (["show", "Rs_int~x"], "expected a whole number from 1"),
        (["show", "Rs_int", "--category", "mugg"], "did you mean mug"),
        (["show", "mug", "--category", "mug"], "name a scene"),
        (["show", "mug", "--habits", "nowhere"], "nowhere"),
        (["survey", "make", "--out", "sheet.txt"], "ending in .csv"),
        (["survey", "make", "--out", "sheet.csv", "--n", "1"], "expected 2 to"),
        (["survey", "make", "--out", "/dev/null/x.csv"], "error: /dev/null: Not a directory; check the path"),
        (
            ["survey", "make", "--out", "s.csv", "--n", "2", "--habits", "one"],
            "dataset 'one' is too small for a survey",
        ),
        (["show", "mug", "--habits", "one/mine.txt"], "one/mine.txt: a file; a book is a folder of *.txt files, give"),
        (["stats", "one/mine.txt"], "one/mine.txt: a file; a book is a folder"),
        (
            ["stats", "one", "--plots", "/dev/null/plots"],
            "/dev/null/plots/plot.png: cannot be written (Not a directory)",
        ),
        (["survey", "score", "no.key.csv", "no.csv"], "no.key.csv: cannot be read"),
        (["survey", "score", "no.key.csv", "a/one.csv", "b/one.csv"], "two sheets are called 'one'"),
    ],
)
def test_mistakes_end_in_one_line(capsys, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "mine.txt").write_text(GOOD)
    assert main(["habits", *words]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert err.count("\n") == 1
    assert out == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--book", "one/mine.txt", "--out", "one.habits.xz"], "one/mine.txt: a file; a book is a folder"),
        (["--book", "one", "--out", "one.txt"], "one.txt: expected a name ending in .habits.xz"),
        (["--book", "one", "--out", "/dev/null/one.habits.xz"], "one.habits.xz: cannot be written (Not a dir"),
        (["--book", "one", "--out", "one.habits.xz", "--doubts", "/dev/null/z"], "/dev/null/z: cannot be"),
        (["--book", "one", "--out", "one.habits.xz", "--doubts", "one"], "one: cannot be written (Is a dir"),
        (["--book", "one", "--out", "one.habits.xz", "--work", "/dev/null/work"], "cannot be written"),
    ],
)
def test_what_cannot_be_built_is_said_before_anything_is_tried(capsys, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ucon.generation.validate._try_block", lambda block: pytest.fail("too late"))
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "mine.txt").write_text(GOOD)
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    assert main(["habits", "build", "--workers", "0", *words]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert message in line


def test_any_command_says_in_one_line_what_the_machine_refuses(capsys, monkeypatch):
    def full(args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ucon.commands.doctor.run", full)
    assert main(["doctor"]) == 2
    assert capsys.readouterr().err == (
        "error: doctor: No space left on device; check the path, its permissions and the free disk space\n"
    )


def test_a_survey_from_sheet_to_score(capsys, tmp_path):
    sheet = tmp_path / "sheet.csv"
    made = json.loads(said(capsys, "survey", "make", "--out", str(sheet), "--n", "6", "--json"))
    assert (made["items"], made["true"], made["swapped"]) == (6, 3, 3)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["sheet.csv", "sheet.html", "sheet.key.csv"]
    (tmp_path / "ana.csv").write_text(sheet.read_text().replace(",,\n", ",4,no\n"))
    scored = json.loads(said(capsys, "survey", "score", made["key"], str(tmp_path / "ana.csv"), "--json"))
    assert scored["real"]["mean"] == 4.0
    assert scored["look"]["yes_true"]["mean"] == 0.0
    assert "1 raters, 6 items" in said(capsys, "survey", "score", made["key"], str(tmp_path / "ana.csv"))
