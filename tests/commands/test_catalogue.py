"""``python -m ucon catalogue``: every name, grouped, on lines that fit a terminal; a word filters them."""

from __future__ import annotations

import pytest

from ucon.__main__ import main
from ucon.objects.catalogue import catalogue


def named(told: str) -> dict[str, list[str]]:
    """Names by group, from the part of the output above the counts."""
    text = told.partition("\n\n")[0].replace("\n  ", " ")
    groups = (line.partition(": ") for line in text.splitlines())
    return {group: names.split(", ") for group, _, names in groups}


def test_every_name_is_there_once_in_its_group(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["catalogue"]) == 0
    told = capsys.readouterr().out
    assert max(map(len, told.splitlines())) <= 80
    groups = named(told)
    assert list(groups) == sorted(groups)
    assert {name: group for group, names in groups.items() for name in names} == {
        row.name: row.semantic_group for row in catalogue()
    }
    assert "\n838 categories, 174 archetypes\n" in told


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["knife"], {"cookware": ["carving_knife", "knife_block", "pocketknife"], "tableware": ["table_knife"]}),
        (["Coffee table"], {"furniture": ["coffee_table"]}),
        (["jewel"], {"jewelry": [row.name for row in catalogue() if row.semantic_group == "jewelry"]}),
        (["cup", "--category", "mug", "--category", "coffee_cup"], {"tableware": ["coffee_cup"]}),
    ],
)
def test_a_word_chooses(words: list[str], found: dict[str, list[str]], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["catalogue", *words]) == 0
    assert named(capsys.readouterr().out) == found


@pytest.mark.parametrize("words", [["scissors"], ["--category", "scissors"]])
def test_a_word_of_no_name_is_answered_with_near_ones(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["catalogue", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: unknown category 'scissors': near in meaning: ")
    assert "shears" in line
