"""Surveys: the questions, the separate key, reading the returned sheets, and their figures."""

import csv
import io
from collections.abc import Sequence
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.datasets.survey import RatedHabit, Rating, draw_items, key_csv, read_key, read_sheet, sheet_csv
from ucon.evaluation.datasets.survey_page import sheet_html
from ucon.evaluation.datasets.survey_score import score_survey
from ucon.habits import book


@pytest.fixture(scope="module")
def items() -> Sequence[RatedHabit]:
    return draw_items(book(), 20, seed=3)


def filled(items: Sequence[RatedHabit], answers: dict[int, tuple[object, object]]) -> str:
    """The sheet as a rater returns it."""
    rows = list(csv.reader(io.StringIO(sheet_csv(items))))
    for row in rows[1:]:
        row[4:] = answers.get(int(row[0]), (4, "yes"))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


@pytest.fixture
def key(items, tmp_path) -> dict[int, RatedHabit]:
    (tmp_path / "sheet.key.csv").write_text(key_csv(items))
    return read_key(tmp_path / "sheet.key.csv")


def test_half_of_the_places_are_true_and_the_others_never(items):
    assert sum(item.truth == "swapped" for item in items) == 10
    assert len({item.object for item in items}) == 20
    for item in items:
        entry = book().entries[book().entry_number[item.entry]]
        (habit,) = [habit for habit in entry.habits if habit.text == item.habit]
        own = {(place.relation, place.anchor) for place in (entry.placements[i] for i in habit.supports)}
        if item.truth == "true":
            assert (item.relation, item.anchor) in own
        else:
            assert item.anchor not in {place.anchor for place in entry.placements}
            others = (p for e in book().entries_of(entry.category) for p in e.placements)
            assert (item.relation, item.anchor) in {(p.relation, p.anchor) for p in others}


def test_same_seed_same_sheet(items):
    assert draw_items(book(), 20, seed=3) == items
    assert draw_items(book(), 20, seed=4) != items


def test_raters_do_not_see_the_key(items):
    hidden = {"swapped", *(item.entry for item in items)}
    for text in (sheet_csv(items), sheet_html(items, "sheet.csv")):
        assert not [word for word in hidden if word in text]


def test_page_is_whole_and_loads_nothing(items):
    nasty = replace(items[0], habit="He says \"a < b\" & '</script><b>' twice.")
    page = sheet_html([nasty, *items[1:]], "</script>.csv")
    parser = HTMLParser()
    tags: list[tuple[str, dict[str, str | None]]] = []
    parser.handle_starttag = lambda tag, attrs: tags.append((tag, dict(attrs)))  # type: ignore[method-assign]
    parser.feed(page)
    cards = [attrs for tag, attrs in tags if attrs.get("class") == "item"]
    assert cards[0]["data-habit"] == nasty.habit
    assert len(cards) == 20
    assert sum(tag == "input" for tag, _ in tags) == 20 * (5 + 3)
    assert page.count("</script>") == 1
    assert "http" not in page
    assert not any("src" in attrs or "href" in attrs for _, attrs in tags)


@pytest.mark.parametrize("n", [0, 1, 10_000])
def test_impossible_numbers_of_items(n):
    with pytest.raises(ConfigError, match="expected 2 to"):
        draw_items(book(), n)


def test_a_survey_needs_labels():
    with pytest.raises(ConfigError, match="does not say which habit supports"):
        draw_items(replace(book(), labelled=False), 20)


def test_scores(items, key, tmp_path):
    swapped = {item.item for item in items if item.truth == "swapped"}
    answers = {"ana": dict.fromkeys(swapped, (5, "no")), "bo": dict.fromkeys(swapped, (5, "Unsure")) | {1: ("", "")}}
    found: list[Rating] = []
    for rater, said in answers.items():
        text = filled(items, said)
        # As some spreadsheet programs save it: with a byte order mark and semicolons.
        path = tmp_path / f"{rater}.csv"
        semicolons = io.StringIO()
        csv.writer(semicolons, delimiter=";").writerows(csv.reader(io.StringIO(text)))
        path.write_text(text if rater == "ana" else "\ufeff" + semicolons.getvalue(), encoding="utf-8", newline="")
        found += read_sheet(path, key)
    figures = score_survey(key, found)
    assert (figures["raters"], figures["items"], figures["answers_real"]) == (2, 20, 39)
    assert figures["look"]["yes_true"]["mean"] == 1.0
    assert figures["look"]["yes_swapped"]["mean"] == 0.0
    assert figures["look"]["difference"]["low"] == 1.0
    assert figures["real"]["low"] < figures["real"]["mean"] < figures["real"]["high"]
    assert figures["alpha_real"]["mean"] == 1.0
    assert 0 < figures["alpha_look"]["mean"] < 1
    assert figures["by_rater"]["ana"] == {"real": 4.5, "yes_true": 1.0, "yes_swapped": 0.0}


def test_one_rater_has_no_agreement(items, key, tmp_path):
    (tmp_path / "ana.csv").write_text(filled(items, {}))
    figures = score_survey(key, read_sheet(tmp_path / "ana.csv", key))
    assert figures["alpha_real"] is figures["alpha_look"] is None


def _bad(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


BAD = {
    "no number": (lambda t: _bad(t, "\n2,", "\ntwo,"), 3, "expected the item's number"),
    "endless number": (lambda t: _bad(t, "\n2,", "\n" + "2" * 5000 + ","), 3, "expected the item's number"),
    "unknown item": (lambda t: _bad(t, "\n2,", "\n222,"), 3, "not in the key"),
    "twice": (lambda t: _bad(t, "\n2,", "\n1,"), 3, "answered twice"),
    "rating": (lambda t: _bad(t, ",4,yes\n", ",6,yes\n"), 2, "from 1 to 5"),
    "look": (lambda t: _bad(t, ",4,yes\n", ",4,perhaps\n"), 2, "expected yes, no, unsure"),
    "columns": (lambda t: _bad(t, ",4,yes\n", ",4,yes,and more\n"), 2, "7 columns, expected 6"),
    "head": (lambda t: _bad(t, "item,object", "thing,object"), 1, "expected item, object"),
    "text": (lambda t: _bad(t, ",on top of the", ",far from the"), None, "differs from the key's"),
    "missing": (lambda t: t[: t.rindex("\n20,") + 1], None, "item 20 is missing"),
    "empty": (lambda t: t.replace(",4,yes\n", ",,\n"), None, "no answer at all"),
    "only a head": (lambda t: t[: t.index("\n") + 1], 1, "no item"),
}


@pytest.mark.parametrize("case", BAD)
def test_malformed_sheets_name_file_and_line(case, items, key, tmp_path):
    spoil, line, message = BAD[case]
    path = tmp_path / "bad.csv"
    path.write_text(spoil(filled(items, {})))
    with pytest.raises(DataError, match=message) as caught:
        read_sheet(path, key)
    assert str(caught.value).startswith(f"{path}:{line}: " if line else str(path))


def test_other_files(key, tmp_path):
    path: Path = tmp_path / "bad.csv"
    with pytest.raises(DataError, match="cannot be read"):
        read_sheet(path, key)
    path.write_bytes(b"item,object\n\xff")
    with pytest.raises(DataError, match=r"bad\.csv:2: not UTF-8"):
        read_sheet(path, key)
    path.write_text("item,object\n")
    with pytest.raises(DataError, match=r"the key of"):
        read_key(path)


def test_two_categories_are_enough():
    """One item with a true place and one with a swapped place; one category is too few for a survey."""
    whole = book()
    names = {item.object.replace(" ", "_") for item in draw_items(whole, 2)}
    two = replace(whole, entries=tuple(entry for entry in whole.entries if entry.category in names))
    assert {item.truth for item in draw_items(two, 2)} == {"true", "swapped"}
    one = replace(whole, entries=tuple(entry for entry in whole.entries if entry.category == min(names)))
    with pytest.raises(ConfigError, match="1 of its categories"):
        draw_items(one, 2)


def test_figures_of_a_rater_have_four_digits(items, key, tmp_path):
    """Ratings 4, 4, 5 and answers yes, yes, no about true places give 4.3333 and 0.6667."""
    true = [item.item for item in items if item.truth == "true"]
    said = {item.item: ("", "") for item in items} | {true[0]: (4, "yes"), true[1]: (4, "yes"), true[2]: (5, "no")}
    (tmp_path / "ana.csv").write_text(filled(items, said))
    figures = score_survey(key, read_sheet(tmp_path / "ana.csv", key))
    assert figures["by_rater"]["ana"] == {"real": 4.3333, "yes_true": 0.6667, "yes_swapped": None}
