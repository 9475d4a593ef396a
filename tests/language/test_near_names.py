"""Suggestions for unknown names: by spelling if the word is misspelt, otherwise also by meaning."""

from __future__ import annotations

import pytest

from ucon.core.errors import DataError
from ucon.language import near_names
from ucon.language.near_names import near_in_meaning, unknown_category


@pytest.mark.parametrize(
    ("word", "meant"),
    [("scissors", "shears"), ("couch", "sofa"), ("spectacles", "eyeglasses"), ("cellphone", "desk_phone")],
)
def test_near_in_meaning(word: str, meant: str) -> None:
    assert meant in near_in_meaning(word)
    assert meant in unknown_category("object", word)


def test_both_are_told() -> None:
    assert unknown_category("object", "glasses") == (
        "unknown object 'glasses': did you mean sunglasses, eyeglasses, wineglass? "
        "near in meaning: eyeglasses, sunglasses, beer_glass"
    )


@pytest.mark.parametrize("word", ["muug", "labtop", "coffee table", "", " ", "x" * 10_000])
def test_what_has_no_meaning_of_its_own(word: str) -> None:
    assert "near in meaning" not in unknown_category("object", word)


def test_what_is_near_nothing() -> None:
    assert near_in_meaning("xyzzy") == ()
    assert "expected one of acetone_atomizer" in unknown_category("object", "xyzzy")


def test_without_the_encoder_spelling_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise DataError("not installed")

    monkeypatch.setattr(near_names, "default_encoder", missing)
    assert near_in_meaning("scissors") == ()
    assert "did you mean mug" in unknown_category("object", "mugs")
