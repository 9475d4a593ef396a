import lzma
import resource

import pytest

from ucon.core.errors import DataError
from ucon.habits import book
from ucon.habits.book import BOOK_FILE
from ucon.habits.datafile import dataset_steps, load_dataset_file, save_dataset
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.habits.verdicts import Verdict, Verdicts

TRIPLE = ("wallet", "ontop", "desk")


def small() -> HabitDataset:
    entry = Entry(
        "wallet/0",
        "wallet",
        "a baker",
        (Placement("ontop", "desk", "summer"), Placement("inside", "backpack")),
        (Habit("He empties his pockets where he writes.", (0,)), Habit("Bread rises at four in the morning.")),
        kind="shop",
    )
    verdicts = Verdicts({TRIPLE: Verdict(2, {"Rs_int": "unstable"})})
    return HabitDataset("mine", (entry,), verdicts=verdicts)


def test_round_trip_and_equal_bytes(tmp_path):
    for name in ("a", "b"):
        save_dataset(small(), tmp_path / f"{name}.habits.xz", {"propose": {"entries": 1}})
    assert (tmp_path / "a.habits.xz").read_bytes() == (tmp_path / "b.habits.xz").read_bytes()
    found = load_dataset_file(tmp_path / "a.habits.xz")
    assert found.entries == small().entries
    assert found.sha256 == small().sha256
    assert found.verdicts.of == small().verdicts.of
    assert dataset_steps(tmp_path / "a.habits.xz") == {"propose": {"entries": 1}}


def test_the_book_loads_in_less_than_half_a_second():
    before = resource.getrusage(resource.RUSAGE_SELF)
    assert len(load_dataset_file(BOOK_FILE, verified=True)) == len(book())
    after = resource.getrusage(resource.RUSAGE_SELF)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 0.5
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
