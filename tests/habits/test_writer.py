"""The parser reads back what the writer writes."""

from dataclasses import replace

import pytest

from ucon.core.errors import DataError
from ucon.habits import book, parse_book
from ucon.habits.book import book_anchors
from ucon.habits.writer import format_entries


def test_the_whole_book_comes_back_equal(tmp_path):
    path = tmp_path / "book.txt"
    path.write_text(format_entries(book().entries), encoding="utf-8")
    assert tuple(parse_book(path, book_anchors())) == book().entries


def test_an_entry_bound_to_a_scene_is_refused():
    with pytest.raises(DataError, match=r"bound to scene 'Rs_int'.*dataset file"):
        format_entries([replace(book().entries[0], scene="Rs_int")])
