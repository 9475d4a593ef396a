"""YAML from others: plain values with their line numbers; everything else is refused in one line."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from ucon.core.errors import DataError
from ucon.core.untrusted.marked_yaml import MOST_BYTES, Marked, marked, parse_marked, read_marked


def plain(node: Marked) -> Any:
    if isinstance(node.value, dict):
        return {key: plain(one) for key, one in node.value.items()}
    return [plain(one) for one in node.value] if isinstance(node.value, list) else node.value


def test_values_have_their_types_and_lines() -> None:
    text = "a: 1\nb: [2.5, -3, 1e3]\nc:\n  d: yes\n  e: 2026-01-01\n  f: '7'\ng: true\nh: ~\ni:\nj: 0x10\n"
    found = parse_marked(text, "x.yaml")
    assert plain(found) == {
        "a": 1,
        "b": [2.5, -3, 1000.0],
        "c": {"d": "yes", "e": "2026-01-01", "f": "7"},
        "g": True,
        "h": None,
        "i": None,
        "j": "0x10",
    }
    assert found.keys["c"] == "x.yaml:3"
    assert found.value["c"].keys["f"] == found.value["c"].value["f"].where == "x.yaml:6"
    assert plain(parse_marked("", "x")) is None


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        ("a: &b [1]\nc: *b\n", 1, "aliases"),
        ("a: 1\nb: *c\n", 2, "aliases"),
        ("a:\n  !!python/object/apply:os.system ['id']\n", 2, "tags"),
        ("a: !include x\n", 1, "tags"),
        ("a: 1\nb: 2\na: 3\n", 3, r"'a' is there twice \(first at x.yaml:1\)"),
        ("a: 1\n---\nb: 2\n", 2, "a second document"),
        ("a: 1\n? [b]\n: 2\n", 2, "a key that is not text"),
        ('a: "x\\u0007"\n', 1, "control character"),
        ('a: "x\\u202e"\n', 1, "control character"),
        ("a: |\n  x\n  y\n", 1, "line break"),
        ("a: x\x07\n", 1, "not YAML"),
        ("a: 1\nb: [1, 2\n", 3, "not YAML"),
        ("a:\n\t- 1\n", 2, "not YAML"),
        ("a: " + "9" * 30 + "\n", 1, "at most 15 digits"),
        ("a: 1e999\n", 1, "at most 15 digits"),
        ("a: " + "9" * 10_000 + "\n", 1, "letters, expected at most"),
        ("a: " + "[" * 5000 + "]" * 5000, 1, "nested too deeply"),
        ("[" + "1," * 50_000 + "]", 1, "too long"),
    ],
)
def test_what_is_refused_says_where(text: str, line: int, part: str) -> None:
    with pytest.raises(DataError, match=rf"^x\.yaml:{line}: .*{part}") as told:
        parse_marked(text, "x.yaml")
    assert "\n" not in str(told.value)
    assert len(str(told.value)) < 250


def test_files_that_are_none(tmp_path: Path) -> None:
    for name, raw, part in (
        ("latin", b"a: caf\xe9\n", ":1: not UTF-8"),
        ("large", b"#" * (MOST_BYTES + 1), "more than"),
    ):
        (tmp_path / name).write_bytes(raw)
        with pytest.raises(DataError, match=part):
            read_marked(tmp_path / name)
    for path in (tmp_path, tmp_path / "nowhere", Path("/dev/zero")):
        with pytest.raises(DataError, match="cannot be read"):
            read_marked(path)


def test_data_of_programs_has_the_same_limits() -> None:
    assert plain(marked({"a": [1, {"b": None}], "c": "x"}, "home")) == {"a": [1, {"b": None}], "c": "x"}
    around: list[Any] = []
    around.append(around)
    for wrong in (
        {1: 2},
        {0: {}},
        {None: 1},
        {False: 1},
        {"": 1},
        {"a": {" ": 1}},
        {"a": object()},
        {"a": float("nan")},
        {"a": 10**20},
        {"a": "x\ny"},
        {"a": around},
        {"a": b"x"},
    ):
        with pytest.raises(DataError, match=r"^home"):
            marked(wrong, "home")


def test_no_text_ends_otherwise() -> None:
    """Texts of all kinds of characters are read, or refused in one line."""
    rng = random.Random(3)
    signs = [
        "a",
        "b: ",
        "- ",
        "[",
        "]",
        "{",
        "}",
        ",",
        "\n",
        "  ",
        ":",
        "&",
        "*",
        "!",
        "'",
        '"',
        "#",
        "|",
        ">",
        "1",
        "~",
    ]
    for _ in range(3000):
        text = "".join(rng.choices(signs, k=rng.randint(1, 25)))
        try:
            parse_marked(text, "x.yaml")
        except DataError as error:
            assert "\n" not in str(error), text  # noqa: PT017
