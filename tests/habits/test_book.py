"""The book's parser: the whole book, and every malformed case raises one typed error that names file and line."""

import shutil
import sys
from pathlib import Path

import pytest

from tests.timing import fastest_s
from ucon.core.errors import ConfigError, DataError
from ucon.habits import book, parse_book
from ucon.habits.book import BOOK_FOLDER, book_anchors, read_anchors, read_book, read_lines
from ucon.objects import model
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS

GOOD = """# wallet | a tidy baker
@ ontop desk
@ inside tote {market days}
@ nextto bed

1: The wallet stays on the desk beside the lamp.
1,3: Either the desk or the bedside has it.
2: On market days it travels in the cloth bag.
-: Bread is sold out before nine every day.
-: Flour gets into every pocket I have ever owned.
-: Nobody may touch the oven before five o'clock.
-: My sister keeps the books and the keys.
-: Sundays are for sleeping until the church bells.
"""


def parse(tmp_path: Path, text: str | bytes):
    path = tmp_path / "habits.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return parse_book(path, book_anchors(), catalogue().names)


@pytest.mark.timed
def test_book_counts_and_speed():
    def load():
        book.cache_clear()
        book()

    assert fastest_s(load) < 0.5
    data = book()
    assert (len(data), len(data.categories), len(data.entries)) == (24_423, 497, 2_443)
    assert len(set(data.texts)) == len(data)


def test_book_names_exist_in_catalogue():
    data = book()
    names = set(catalogue().names)
    assert set(data.categories) <= names
    assert set(data.anchors) <= names
    assert RELATIONS == model.RELATIONS


def test_rows_and_supports_agree():
    data = book()
    rows = {c: data.rows_of_entries(data.entries_of(c)) for c in data.categories}
    assert sum(map(len, rows.values())) == len(data)
    for category in data.categories[::50]:
        for row in rows[category]:
            entry = data.entry_of(row)
            assert entry.category == category
            assert data.supports(row) == tuple(entry.placements[i] for i in data.habits[row].supports)
    with pytest.raises(ConfigError, match="did you mean"):
        data.entries_of("walet")


def test_good_entry(tmp_path):
    (entry,) = parse(tmp_path, GOOD)
    assert entry.id == "wallet/0"
    assert entry.household == "a tidy baker"
    assert entry.placements[1].context == "market days"
    assert [h.supports for h in entry.habits[:4]] == [(0,), (0, 2), (1,), ()]
    assert parse(tmp_path, GOOD.replace("\n", "\r\n")) == [entry]


BAD = {
    "unknown category": (GOOD.replace("# wallet", "# walet"), 1, "unknown category 'walet': did you mean wallet"),
    "bad header": (GOOD.replace("# wallet |", "# wallet"), 1, "bad header"),
    "no household": (GOOD.replace("a tidy baker", ""), 1, "bad header"),
    "unknown anchor": (GOOD.replace("ontop desk", "ontop desc"), 2, "unknown anchor 'desc'"),
    "unknown relation": (GOOD.replace("@ ontop", "@ above"), 2, "unknown relation 'above'"),
    "relation not allowed": (GOOD.replace("nextto bed", "inside bed"), 4, "expected one of"),
    "onto itself": (GOOD.replace("wallet", "tote"), 3, "onto itself"),
    "placement twice": (GOOD.replace("nextto bed", "ontop desk"), 4, "listed twice"),
    "bad placement": (GOOD.replace("@ ontop desk", "@ ontop the desk"), 2, "bad placement"),
    "unclosed context": (GOOD.replace("days}", "days"), 3, "bad placement"),
    "bad habit line": (GOOD.replace("2: On", "two: On"), 8, "bad habit"),
    "no such placement": (GOOD.replace("2: On", "4: On"), 8, "no placement 4; the entry has 3"),
    "placement named twice": (GOOD.replace("1,3:", "1,1:"), 7, "named twice"),
    "habit too short": (GOOD.replace("On market days it travels in the cloth bag.", "In the bag."), 8, "3 words"),
    "underscore": (GOOD.replace("cloth bag", "cloth_bag"), 8, "underscore"),
    "oversized line": (GOOD.replace("cloth bag", "b" * 400), 8, "at most 400"),
    "control character": (GOOD.replace("cloth bag", "cloth\x00bag"), 8, "control character"),
    "placement after habits": (GOOD.replace("-: Bread", "@ nextto sink\n-: Bread"), 9, "placement after habits"),
    "too few placements": (GOOD.replace("@ nextto bed\n", "").replace("1,3:", "1:"), 1, "2 placements"),
    "cut between lines": ("\n".join(GOOD.split("\n")[:9]) + "\n", 1, "cut off"),
    "cut inside a line": (GOOD[:-20], 13, "cut off"),
    "habit before entry": ("1: The wallet stays on the desk.\n" + GOOD, 1, "before the first entry"),
    "invalid UTF-8": (GOOD.encode().replace(b"cloth", b"cl\xffth"), 8, "not UTF-8"),
    "empty": ("\n\n", 1, "empty"),
    "no entry": ("\n# x\n", 2, "bad header"),
}


@pytest.mark.parametrize("case", BAD)
def test_malformed(tmp_path, case):
    text, line, message = BAD[case]
    with pytest.raises(DataError) as caught:
        parse(tmp_path, text)
    assert f"habits.txt:{line}: " in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_faults_of_a_folder_are_told_at_once(tmp_path):
    (tmp_path / "anchors.txt").write_text("A desk: ontop\nA bed: beside nextto\n")
    (tmp_path / "a.txt").write_text(
        "# walet | two people\n@ ontop desk\n@ ontop\n@ under desk\n1: It lies there, most of the time.\n"
        "3: The desk is where it goes in the evening.\n9 It lies there.\n\n"
        "# wallet | one person\n@ nextto bed\n2: By the bed, where the book lies.\n1: A long_word.\n"
    )
    (tmp_path / "b.txt").write_bytes(b"# wallet | \xff\n")
    (tmp_path / "c.txt").write_text("# wallet | two people\n@ ontop desk\n1: On the desk by the door, mostly.\n")
    with pytest.raises(DataError) as caught:
        read_book(tmp_path, catalogue().names)
    first, *told = str(caught.value).split("\n")
    assert first == f"{tmp_path}: 8 faults:"
    assert [line.strip().removeprefix(f"{tmp_path}/").split(": ")[0] for line in told] == [
        "anchors.txt:2", "a.txt:1", "a.txt:3", "a.txt:4", "a.txt:7", "a.txt:11", "a.txt:12", "b.txt:1",
    ]  # fmt: skip
    for line, rule in zip(
        told,
        ["unknown relation", "did you mean wallet", "bad placement", "nothing is under", "bad habit", "no placement 2",
         "underscore", "not UTF-8"],
        strict=True,
    ):  # fmt: skip
        assert rule in line


def test_of_many_faults_the_first_are_told(tmp_path):
    (tmp_path / "a.txt").write_text("# wallet | two people\n@ ontop desk\n" + "2: On the desk, mostly.\n" * 50)
    with pytest.raises(DataError) as caught:
        read_book(tmp_path)
    first, *told = str(caught.value).split("\n")
    assert first == f"{tmp_path}: 50 faults, the first 20:"
    assert len(told) == 20


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_lines(tmp_path / "no.txt")
    with pytest.raises(DataError, match="no habit file"):
        read_book(tmp_path)


def test_bad_anchor_file(tmp_path):
    path = tmp_path / "anchors.txt"
    path.write_text("A desk: ontop\nA desk: under\n")
    with pytest.raises(DataError, match=r"anchors.txt:2: .*twice"):
        read_anchors(path)
    path.write_text("A desk: beside\n")
    with pytest.raises(DataError, match=r"anchors.txt:1: unknown relation"):
        read_anchors(path)


def test_anchors_of_the_embedded_book_can_be_extended(tmp_path, monkeypatch):
    shutil.copytree(BOOK_FOLDER, tmp_path / "book")
    monkeypatch.setattr(sys.modules["ucon.habits.book"], "BOOK_FOLDER", tmp_path / "book")
    new = next(name for name in catalogue().names if name not in book_anchors())
    with (tmp_path / "book" / "anchors.txt").open("a") as file:
        file.write(f"M {new}: nextto\n")
    (tmp_path / "book" / "mine.txt").write_text(GOOD.replace("nextto bed", f"nextto {new}"))
    assert new in read_book(tmp_path / "book", catalogue().names).anchors
    with pytest.raises(DataError, match=r"anchors\.txt.*truncated or altered"):
        read_book(tmp_path / "book", verified=True)


def test_altered_book_file_is_noticed(tmp_path):
    shutil.copytree(BOOK_FOLDER, tmp_path / "book")
    file = next(p for p in sorted((tmp_path / "book").glob("*.txt")) if p.name != "anchors.txt")
    raw = bytearray(file.read_bytes())
    raw[1000] ^= 1
    file.write_bytes(raw)
    with pytest.raises(DataError, match="truncated or altered"):
        read_book(tmp_path / "book", verified=True)


def test_entries_of_a_category_in_two_files_are_numbered_on(tmp_path):
    for name in ("a.txt", "b.txt"):
        (tmp_path / name).write_text(GOOD)
    ids = [entry.id for entry in read_book(tmp_path).entries]
    assert len(set(ids)) == len(ids) > 1
    assert [int(i.split("/")[1]) for i in ids if i.startswith("wallet/")] == list(range(len(ids)))


def test_the_shipped_file_is_what_the_text_says():
    text = read_book(BOOK_FOLDER, verified=True)
    assert text.sha256 == book().sha256, "the book's text has changed: run `python -m ucon habits build`"
    assert book().verdicts.of


def test_a_blank_line_stands_before_every_entry_of_the_book():
    for path in BOOK_FOLDER.glob("*.txt"):
        lines = path.read_text().split("\n")
        assert not [n for n, line in enumerate(lines) if n and line.startswith("# ") and lines[n - 1]], path.name


def test_kinds_of_places(tmp_path):
    (tmp_path / "a.txt").write_text(GOOD.replace("\n", " {office}\n", 1))
    (entry,) = read_book(tmp_path).entries
    assert entry.kind == "office"
    assert "{" not in entry.household
    (tmp_path / "a.txt").write_text(GOOD.replace("\n", " {offce}\n", 1))
    with pytest.raises(DataError, match=r"a\.txt:1: unknown kind of place 'offce': did you mean office"):
        read_book(tmp_path)
