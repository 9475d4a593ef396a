"""The pipeline as one call, on a small book."""

import json
import sys

import pytest

from tests.habits.test_book import GOOD
from tests.habits.test_datafile import steps_of
from ucon.__main__ import main
from ucon.core.errors import DataError
from ucon.core.files import read_verified
from ucon.generation.build import build
from ucon.habits.book import ANCHORS, BOOK_FOLDER
from ucon.habits.datafile import load_dataset_file


@pytest.fixture
def folder(tmp_path):
    book = tmp_path / "book"
    book.mkdir()
    (book / "mine.txt").write_text(GOOD)
    return book


def test_equal_text_gives_equal_bytes_in_any_number_of_processes(tmp_path, folder):
    files = []
    for workers in (0, 2):
        out = tmp_path / f"{workers}.habits.xz"
        files.append(build(out, book=folder, work=tmp_path / f"work{workers}", workers=workers))
    assert files[0].path.read_bytes() == files[1].path.read_bytes()
    dataset = load_dataset_file(files[0].path)
    assert set(dataset.verdicts.of) == {
        ("wallet", "ontop", "desk"),
        ("wallet", "inside", "tote"),
        ("wallet", "nextto", "bed"),
    }
    steps = steps_of(files[0].path)
    assert steps["propose"] == {"entries": 1, "habits": 8, "categories": 1, "placements": 3}
    assert steps["validate"]["triples"] == 3
    assert steps["verify"]["pairs"] == 24


def test_the_command_writes_the_file_and_the_doubts(tmp_path, folder, capsys):
    wrong = GOOD.replace("1: The wallet stays on the desk", "3: The wallet stays on the desk")
    (folder / "mine.txt").write_text(wrong)
    out, doubts = tmp_path / "mine.habits.xz", tmp_path / "doubts.txt"
    words = ["habits", "build", "--book", str(folder), "--out", str(out), "--work", str(tmp_path / "work"), "--json"]
    assert main([*words, "--doubts", str(doubts), "--workers", "0"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["verify"]["doubted_supports"] + figures["verify"]["doubted_distractors"] >= 1
    assert "The wallet stays on the desk" in doubts.read_text()
    assert figures["doubts"] == doubts.read_text().splitlines()
    assert main([word for word in words if word != "--json"]) == 0
    assert "The wallet stays on the desk" in capsys.readouterr().out
    assert load_dataset_file(out).sha256 == figures["sha256"]


@pytest.fixture
def shipped(tmp_path, monkeypatch):
    """A small embedded book and its file, in temporary folders."""
    text, file = tmp_path / "embedded", tmp_path / "data" / "book.habits.xz"
    text.mkdir()
    (text / ANCHORS).write_bytes((BOOK_FOLDER / ANCHORS).read_bytes())
    (text / "theirs.txt").write_text(GOOD.replace("tidy", "sleepy"))
    monkeypatch.setattr(sys.modules["ucon.habits.book"], "BOOK_FOLDER", text)
    monkeypatch.setattr(sys.modules["ucon.habits.book"], "BOOK_FILE", file)
    assert main(["habits", "build", "--work", str(tmp_path / "work"), "--workers", "0"]) == 0
    assert read_verified(file)
    assert read_verified(text / "theirs.txt")
    return file


def test_a_book_of_ones_own_does_not_replace_the_shipped_one(tmp_path, folder, shipped, capsys):
    before = shipped.read_bytes()
    words = ["habits", "build", "--book", str(folder), "--work", str(tmp_path / "work"), "--workers", "0"]
    capsys.readouterr()
    assert main(words) == 2
    assert "--out" in capsys.readouterr().err
    assert shipped.read_bytes() == before


def test_a_manifest_never_lists_a_book_of_ones_own(tmp_path, folder, shipped):
    words = ["habits", "build", "--book", str(folder), "--work", str(tmp_path / "work"), "--workers", "0"]
    assert main([*words, "--out", str(shipped)]) == 0
    with pytest.raises(DataError, match="truncated or altered"):
        read_verified(shipped)
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]


def test_malformed_text_is_refused_before_anything_is_tried(tmp_path, folder):
    (folder / "mine.txt").write_text(GOOD.replace("@ ontop desk", "@ ontop dsk"))
    with pytest.raises(DataError, match=r"mine\.txt:2: unknown anchor 'dsk'"):
        build(tmp_path / "a.habits.xz", book=folder, work=tmp_path / "work")
    assert not (tmp_path / "work").exists()
