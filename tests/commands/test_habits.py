"""``habits show`` and ``habits survey`` as a user meets them, in this process."""

import json

import pytest

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
        (["survey", "score", "no.key.csv", "no.csv"], "no.key.csv: cannot be read"),
        (["survey", "score", "no.key.csv", "a/one.csv", "b/one.csv"], "two sheets are called 'one'"),
    ],
)
def test_mistakes_end_in_one_line(capsys, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["habits", *words]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert err.count("\n") == 1
    assert out == ""


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
