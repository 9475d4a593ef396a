"""The strict reader of JSON: what it refuses, and that it reads everything else as Python's own reader does."""

import json
from pathlib import Path

import pytest

from ucon.core.errors import DataError
from ucon.core.untrusted.strict_json import MAX_DEPTH, MAX_INT, JsonError, parse_json, read_json

REFUSED = {
    "nothing": "",
    "half": '{"a": 1',
    "more after it": "{} {}",
    "not a number": '{"a": NaN}',
    "infinity": "[-Infinity]",
    "float beyond the largest": "[1e999]",
    "400 digits": f"[1{'0' * 400}]",
    "10,000 digits": f"[1{'0' * 10_000}]",
    "64 bits": f"[{MAX_INT + 1}]",
    "nested by one too many": "[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1),
    "nested in objects": '{"a":' * (MAX_DEPTH + 1) + "1" + "}" * (MAX_DEPTH + 1),
    "nested past texts of brackets": '["]", ' * (MAX_DEPTH + 1) + "1" + ', "["]' * (MAX_DEPTH + 1),
    "nested 100,000 times": "[" * 100_000 + "]" * 100_000,
    "nested and never closed": "[" * 100_000,
    "a key twice": '{"a": 1, "b": {"c": 1, "c": 2}}',
    "half a character": r'["\ud83d"]',
    "NUL": "[1]\x00",
    "no UTF-8": b'["\xff"]',
    "cut inside a letter": '["é'.encode()[:-1],
}


@pytest.mark.parametrize("text", REFUSED.values(), ids=REFUSED)
def test_refuses_in_one_line(text: str | bytes, tmp_path: Path) -> None:
    with pytest.raises(JsonError) as refused:
        parse_json(text)
    assert len(str(refused.value)) < 200
    assert str(refused.value).isprintable()
    file = tmp_path / "some.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DataError, match=r"some\.json[:\d]*: .*; make it anew$"):
        read_json(file, "make it anew")


@pytest.mark.parametrize(
    "value",
    [
        *(None, True, 0, -MAX_INT, MAX_INT, 1.5, 1e308, "", "]]]]{{{{", [], {}, {"a": [1, {"b": None}]}),
        json.loads("[" * MAX_DEPTH + "]" * MAX_DEPTH),
        [["[{" * MAX_DEPTH]],
        "家 ☕️ 👩‍🍳 é",
    ],
)
@pytest.mark.parametrize("ascii_only", [True, False])
def test_reads_what_python_writes(value: object, ascii_only: bool) -> None:
    text = json.dumps(value, ensure_ascii=ascii_only)
    assert parse_json(text) == value
    assert parse_json(b"\xef\xbb\xbf" + text.encode() + b"\r\n") == value


def test_keys_twice_can_be_noted_and_half_characters_let_through() -> None:
    twice: list[str] = []
    assert parse_json('{"a": 1, "a": 2}', twice=twice) == {"a": 2}
    assert twice == ["a"]
    assert parse_json(r'"\ud83d"', surrogates=True) == "\ud83d"


def test_a_file_is_not_read_beyond_its_limit(tmp_path: Path) -> None:
    file = tmp_path / "large.json"
    with file.open("wb") as written:
        written.truncate(1 << 40)  # a sparse file of a terabyte
    with pytest.raises(DataError, match="expected at most 1,000"):
        read_json(file, "remove it", max_bytes=1000)
    for path in (tmp_path, tmp_path / "none.json"):
        with pytest.raises(DataError, match="cannot be read"):
            read_json(path, "restore it")
