"""Warnings when a dataset is loaded by path: what is left out and why, other languages; and byte order marks."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from ucon.configuration.wiring import folder_habits, official_habits
from ucon.core.output import say_once
from ucon.habits.book import BOOK_FOLDER


@pytest.fixture(autouse=True)
def anew() -> None:
    say_once.cache_clear()


def task(**changes: Any) -> dict[str, Any]:
    made = {
        "user_instruction": "A nurse",
        "basic_object_name": "mug",
        "habits": ["She leaves it on the shelf after dinner \U0001f469\u200d\U0001f373.", "It is by the bed at night."],
        "location": ["mug.place_ontop(shelf)"],
    }
    return made | changes


def written(folder: Path, tasks: list[dict[str, Any]], mark: bytes = b"") -> str:
    path = folder / "task.json"
    path.write_bytes(mark + json.dumps({"Rs_int": {"mug": tasks}}, ensure_ascii=False).encode())
    return str(path)


def test_what_is_left_out_is_said_once_and_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(
        tmp_path,
        [
            task(habits=["It hangs there.", "bell \x07", 7]),
            task(location=["mug.place_ontop(no_such_thing)", "mug.place_ontop(bed)"]),
            task(location=["mug.place_ontop(nothing_here)"]),
        ],
    )
    for _ in range(2):
        assert len(official_habits(path)) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert f"warning: {path}: 4 of 7 habits and 2 of 4 locations left out" in line
    assert "2 x unknown anchor category ..." in line
    assert "`python -m ucon habits import` lists each" in line


def test_nothing_is_said_of_a_whole_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(official_habits(written(tmp_path, [task()]))) == 2
    assert not capsys.readouterr().err


def test_another_language_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    german = ["Die Tasse steht nach dem Frühstück immer auf dem Regal.", "Nachts steht sie neben dem Bett."]
    official_habits(written(tmp_path, [task(habits=german)]))
    (line,) = capsys.readouterr().err.splitlines()
    assert "do not look English" in line


def test_byte_order_marks_and_carriage_returns_change_nothing(tmp_path: Path) -> None:
    plain = official_habits(written(tmp_path, [task()])).sha256
    assert official_habits(written(tmp_path, [task()], b"\xef\xbb\xbf")).sha256 == plain
    folder = tmp_path / "book"
    folder.mkdir()
    name = sorted(path.name for path in BOOK_FOLDER.glob("*.txt") if path.name != "anchors.txt")[0]
    for file in (name, "anchors.txt"):
        shutil.copy(BOOK_FOLDER / file, folder)
    right = folder_habits(str(folder)).sha256
    for file in (name, "anchors.txt"):
        path = folder / file
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert folder_habits(str(folder)).sha256 == right
