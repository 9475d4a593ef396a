"""One flipped bit anywhere in a run's folder is an error in one line, or changes nothing that is read."""

import contextlib
import io
import lzma
import shutil
from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.records import played as made_up
from tests.evaluation.records import store
from ucon.__main__ import main
from ucon.core.errors import UconError
from ucon.core.rng import stream
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.record import read_records
from ucon.evaluation.kept.seal import PARTIAL, RECORDS, SEALED, SUMMARY

HASHES = {"config": "c", "episodes": "e"}
CONFIG = "env: {planner: 'true'}\ntask: {name: paper, context: false}\nepisodes: mini\n"
FILES = sorted({name for part in SEALED.items() for name in (part[0], *part[1])})


def played(number):
    """An episode with two choices for which a model was asked."""
    one = made_up(number, success=number % 3 != 0)
    choice = DecisionRecord(one.record.episode, 0, 3, "view", ("vorn", "zurück"), 1, (0.5, 0.25), asked=2, seconds=0.5)
    made = (choice, replace(choice, number=1, seconds=0.25))
    return replace(one, decisions=made, timing=replace(one.timing, decision_seconds=(0.5, 0.25)))


PLAYED = [played(number) for number in range(6)]
IDS = [one.record.episode for one in PLAYED]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return store(tmp_path_factory.mktemp("flipped") / "run", PLAYED, config=CONFIG)


def bits(size: int, name: str) -> list[int]:
    """Up to 64 bits of a file, including its first and last byte."""
    drawn = stream(0, "flipped", name).integers(8 * size, size=60)
    return sorted({0, 7, 8 * size - 1, 8 * size - 8, *map(int, drawn)})


def flipped(raw: bytes, bit: int) -> bytes:
    changed = bytearray(raw)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def told(*words) -> tuple[int, str, str]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(map(str, words)))
    return code, out.getvalue(), err.getvalue()


@pytest.mark.parametrize("name", FILES)
def test_no_bit_of_a_finished_run_changes_what_is_read(name, run, tmp_path):
    folder = shutil.copytree(run, tmp_path / "run")
    assert told("verify", folder)[0] == 0
    raw = (folder / name).read_bytes()
    for bit in bits(len(raw), name):
        (folder / name).write_bytes(flipped(raw, bit))
        with pytest.raises(UconError) as caught:
            RunFolder(folder, {}).open(IDS)
        assert "\n" not in str(caught.value)
        code, out, err = told("verify", folder)
        assert (code, out, err.count("\n")) == (1, "", 1), bit
        assert folder.name in err
        assert told("verify", folder, "--seal")[0] == 1, "damage is not sealed"
    for command in (("compare", folder, run), ("cases", folder)):
        code, _, err = told(*command)
        assert (code, err.count("\n")) == (2, 1), command


def test_no_bit_of_packed_records_changes_what_is_read(run, tmp_path):
    folder = shutil.copytree(run, tmp_path / "run")
    whole, raw = read_records(folder), lzma.compress((folder / RECORDS).read_bytes())
    (folder / RECORDS).unlink()
    packed, refused = folder / f"{RECORDS}.xz", 0
    for bit in bits(len(raw), packed.name):
        packed.write_bytes(flipped(raw, bit))
        try:
            assert read_records(folder) == whole
        except UconError:
            refused += 1
    assert refused > 50


def test_no_bit_of_an_unfinished_run_changes_what_is_continued(tmp_path):
    path = tmp_path / "run"
    folder = RunFolder(path, HASHES)
    folder.open(IDS)
    for one in PLAYED:
        folder.add(one)
    raw, refused, lost = (path / PARTIAL).read_bytes(), 0, 0
    for bit in bits(len(raw), PARTIAL) + list(range(5, 8 * len(raw), 8 * 41)):
        (path / PARTIAL).write_bytes(flipped(raw, bit))
        again = RunFolder(path, HASHES)
        if bit // 8 <= raw.index(b"\n"):
            with pytest.raises(UconError, match="its first line is damaged"):
                again.open(IDS)
            refused += 1
            continue
        done = again.open(IDS)
        assert all(done[index] == PLAYED[index] for index in done)
        assert len(done) >= len(PLAYED) - 2
        lost += len(done) < len(PLAYED)
    assert refused > 0 < lost


def test_records_by_path_are_checked_against_the_summary_beside_them(run, tmp_path):
    folder = shutil.copytree(run, tmp_path / "run")
    records = folder / "episodes.jsonl"
    assert told("compare", records, run)[0] == 0
    records.write_bytes(records.read_bytes().replace(b'"n_habits":20', b'"n_habits":21', 1))
    code, _, err = told("compare", records, run)
    assert (code, err.count("\n")) == (2, 1)
    assert "SHA-256" in err
    (folder / SUMMARY).unlink()
    assert told("compare", records, run)[0] == 0, "alone it is as good as any"


def test_reading_a_thousand_episodes_takes_no_time(tmp_path):
    from time import process_time

    folder = store(tmp_path / "run", [replace(made_up(n), index=n) for n in range(1000)])
    spent = []
    for _ in range(3):
        begun = process_time()
        RunFolder(folder, {}).open([f"e{n}" for n in range(1000)])
        spent.append(process_time() - begun)
    assert np.min(spent) < 0.4  # with the timing of each; about 0.1 on an idle core
