"""The catalogue file is read completely, and damage is reported with file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.timing import fastest_s
from ucon.core.errors import ConfigError, DataError
from ucon.objects import catalogue
from ucon.objects.catalogue import CATALOGUE_FILE, read_catalogue

LINES = CATALOGUE_FILE.read_text(encoding="utf-8").splitlines()


def column(name: str) -> int:
    return LINES[0].split(",").index(name)


def test_what_it_holds() -> None:
    book = catalogue()
    assert len(book) == 838
    assert len({row.archetype for row in book}) == 174
    assert sum(row.official_target for row in book) == 489
    assert {row.official_split for row in book if row.official_target} == {"train", "test"}
    assert list(book.names) == sorted(book.names)
    assert book["coffee_table"].phrase == "coffee table"
    assert "coffee_table" in book
    assert "coffee table" not in book
    for row in book:
        assert row.mass_kg > 0
        assert row.rooms
        if row.mount == "wall":
            assert 0 <= row.bottom_z_m < 2.4


def test_no_counts_of_held_out_placements() -> None:
    words = ("anchor", "task", "scene", "count", "nextto", "relation")
    assert not [name for name in LINES[0].split(",") if any(word in name for word in words)]
    assert not [line for line in LINES[1:] if "locations" in line.rsplit(",", 1)[-1]]


def test_unknown_name_is_answered_with_near_ones() -> None:
    with pytest.raises(ConfigError, match="did you mean fridge"):
        catalogue()["frigde"]


@pytest.mark.timed
def test_reading_is_quick() -> None:
    assert fastest_s(lambda: read_catalogue(CATALOGUE_FILE)) < 0.06


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x_m", "-1", "x_m is '-1', expected a number from"),
        ("z_m", "tall", "expected a number"),
        ("mass_kg", "", "expected a number"),
        ("mount", "sky", "expected one of surface, floor"),
        ("openable", "yes", "expected one of 0, 1"),
        ("rgb", "300 0 0", "from 0 to 255"),
        ("interior_frac", "0.5 0.5", "three numbers"),
        ("rooms", "", "expected text"),
    ],
)
def test_damaged_row(tmp_path: Path, field: str, value: str, message: str) -> None:
    row = LINES[4].split(",")
    row[column(field)] = value
    path = tmp_path / "catalogue.csv"
    path.write_text("\n".join([*LINES[:4], ",".join(row), *LINES[5:]]), encoding="utf-8")
    with pytest.raises(DataError, match=message) as caught:
        read_catalogue(path)
    assert f"{path}:5: {row[0]}" in str(caught.value)


def test_damaged_file(tmp_path: Path) -> None:
    path = tmp_path / "catalogue.csv"
    with pytest.raises(DataError, match="cannot be read"):
        read_catalogue(path)
    path.write_text("\n".join([*LINES[:6], LINES[6][:20]]), encoding="utf-8")
    with pytest.raises(DataError, match=r":7: .* fields, expected"):
        read_catalogue(path)
    path.write_text("\n".join([*LINES[:6], LINES[3]]), encoding="utf-8")
    with pytest.raises(DataError, match=r":7: category .* twice"):
        read_catalogue(path)
    path.write_text("name,size\n", encoding="utf-8")
    with pytest.raises(DataError, match=":1: columns are name, size"):
        read_catalogue(path)
