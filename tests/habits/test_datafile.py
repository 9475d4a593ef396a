import json
import lzma
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ucon.configuration.wiring import folder_habits
from ucon.core.errors import DataError
from ucon.habits import book
from ucon.habits.book import BOOK_FILE
from ucon.habits.datafile import load_dataset_file, save_dataset
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.habits.verdicts import Verdict, Verdicts

TRIPLE = ("wallet", "ontop", "desk")


def small() -> HabitDataset:
    entry = Entry(
        "wallet/0",
        "wallet",
        "a baker",
        (Placement("ontop", "desk", "summer"), Placement("inside", "backpack"), Placement("nextto", "bed")),
        (
            Habit("He empties his pockets where he writes.", (0,)),
            *(Habit(f"Bread rises at {hour} in the morning.") for hour in range(7)),
        ),
        kind="shop",
    )
    verdicts = Verdicts({TRIPLE: Verdict(2, {"Rs_int": "unstable"})})
    return HabitDataset("mine", (entry,), verdicts=verdicts)


def steps_of(path: Path) -> dict[str, Any]:
    """The steps by which a dataset file was made, from its header."""
    return dict(json.loads(lzma.decompress(path.read_bytes()).split(b"\n")[0])["steps"])


def test_round_trip_and_equal_bytes(tmp_path):
    for name in ("a", "b"):
        save_dataset(small(), tmp_path / f"{name}.habits.xz", {"propose": {"entries": 1}})
    assert (tmp_path / "a.habits.xz").read_bytes() == (tmp_path / "b.habits.xz").read_bytes()
    found = load_dataset_file(tmp_path / "a.habits.xz")
    assert found.entries == small().entries
    assert found.sha256 == small().sha256
    assert found.verdicts.of == small().verdicts.of
    assert steps_of(tmp_path / "a.habits.xz") == {"propose": {"entries": 1}}


@pytest.mark.timed
def test_the_book_loads_in_less_than_half_a_second():
    """CPU time in a separate process: in this one, the garbage collector would also walk the other tests' objects."""
    program = (
        "import time; from ucon.habits.book import BOOK_FILE; from ucon.habits.datafile import load_dataset_file;"
        "start = time.process_time(); n = len(load_dataset_file(BOOK_FILE, verified=True));"
        "print(n, time.process_time() - start)"
    )
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert int(said[0]) == len(book())
    assert float(said[1]) < 0.5
    assert BOOK_FILE.stat().st_size < 2e6


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda raw: raw[: len(raw) // 2], "not a whole dataset file|do not match|entries"),
        (lambda raw: raw[:100] + bytes([raw[100] ^ 255]) + raw[101:], "not a whole dataset file|checksum"),
        (lambda raw: b"plain text", "not a whole dataset file"),
        (lambda raw: changed(raw, '"version":1', '"version":9'), "format ucon-habits 9, expected ucon-habits 1"),
        (lambda raw: changed(raw, "empties", "fills"), "do not match their checksum"),
        (lambda raw: changed(raw, "ucon-habits", "other"), "expected ucon-habits"),
    ],
)
def test_damaged_files_are_refused(tmp_path, damage, message):
    path = tmp_path / "a.habits.xz"
    save_dataset(small(), path)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(DataError, match=message) as error:
        load_dataset_file(path)
    assert "a.habits.xz" in str(error.value)


def with_habit(text: str) -> Callable[[Entry], Entry]:
    return lambda entry: replace(entry, habits=(*entry.habits[:-1], Habit(text)))


def with_place(**changes: Any) -> Callable[[Entry], Entry]:
    return lambda entry: replace(entry, placements=(replace(entry.placements[0], **changes), *entry.placements[1:]))


BROKEN: dict[str, tuple[Callable[[Entry], Entry], str]] = {
    "category": (lambda e: replace(e, category="unicorn"), "unknown category 'unicorn'"),
    "anchor": (with_place(anchor="moon_rock"), "unknown anchor 'moon_rock'"),
    "onto itself": (with_place(anchor="wallet"), "a wallet placed onto itself"),
    "place twice": (with_place(relation="nextto", anchor="bed"), "'nextto bed' is listed twice"),
    "long context": (with_place(context="summer " * 100), "700 characters, at most 400"),
    "long sentence": (with_habit("x" * 2**20), "1048576 characters, at most 400"),
    "many words": (with_habit("a b " * 41), "82 words, expected 1 to 80"),
    "many places": (lambda e: replace(e, placements=e.placements[:1] * 10), "10 placements, expected 1 to 9"),
    "many habits": (lambda e: replace(e, habits=e.habits[:1] * 1001), "1001 habits, expected 1 to 1000"),
    "no household": (lambda e: replace(e, household=""), "household ''"),
    "kind": (lambda e: replace(e, kind="shopp"), "unknown kind of place 'shopp'"),
    "id twice": (lambda e: replace(e, id="wallet/0"), "entry 'wallet/0': another entry has this id"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_breaks_a_rule_is_refused_with_line_and_entry(tmp_path, case):
    change, message = BROKEN[case]
    good = small().entries[0]
    broken = change(replace(good, id="wallet/1"))
    path = tmp_path / "a.habits.xz"
    save_dataset(replace(small(), entries=(good, replace(good, id="wallet/2"))), path)
    assert len(folder_habits(str(path)).entries) == 2
    save_dataset(replace(small(), entries=(good, broken)), path)
    with pytest.raises(DataError) as error:
        folder_habits(str(path))
    assert str(error.value).startswith(f"{path}:3: entry '{broken.id}': ")
    assert message in str(error.value)
    assert len(str(error.value)) < 500


def test_the_shipped_file_keeps_the_rules(tmp_path):
    path = tmp_path / "copy.habits.xz"
    path.write_bytes(BOOK_FILE.read_bytes())
    assert folder_habits(str(path)).sha256 == book().sha256


def changed(raw: bytes, old: str, new: str) -> bytes:
    text = lzma.decompress(raw).decode()
    assert old in text
    return lzma.compress(text.replace(old, new, 1).encode())


def test_verdicts():
    verdicts = small().verdicts
    assert verdicts.refusal(TRIPLE, "Rs_int") == "unstable"
    assert verdicts.refusal(TRIPLE, "Merom_1_int") is None
    assert verdicts.refusal(("cap", "ontop", "desk"), "Rs_int") is None
    everywhere = Verdicts({TRIPLE: Verdict(2, {"Rs_int": "unstable", "Merom_1_int": "too_large"})})
    assert everywhere.refusal(TRIPLE, "procedural:house:3") in ("unstable", "too_large")
    absent = Verdicts({TRIPLE: Verdict(2, {"Rs_int": "not_importable", "Merom_1_int": "absent_anchor"})})
    assert absent.refusal(TRIPLE, "Rs_int") == "not_importable"
    assert absent.refusal(TRIPLE, "procedural:house:3") is None, "another home may have the anchor"
