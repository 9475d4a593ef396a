import json

import pytest

from tests.evaluation.records import played
from ucon.core.errors import ConfigError
from ucon.evaluation.folder import PARTIAL, RECORDS, SUMMARY, RunFolder

HASHES = {"config": "c", "episodes": "e", "habits": "h", "code": "v"}


def interrupted(path, numbers):
    folder = RunFolder(path, HASHES)
    folder.open()
    for number in numbers:
        folder.add(played(number))
    return path / PARTIAL


def test_goes_on_where_it_was_interrupted(tmp_path):
    interrupted(tmp_path, [2, 0])
    assert RunFolder(tmp_path, HASHES).open() == {0: played(0), 2: played(2)}


def test_a_line_cut_off_in_mid_write_is_played_again(tmp_path):
    partial = interrupted(tmp_path, [0, 1])
    partial.write_text(partial.read_text()[:-30])
    folder = RunFolder(tmp_path, HASHES)
    assert set(folder.open()) == {0}
    folder.add(played(1))
    assert set(RunFolder(tmp_path, HASHES).open()) == {0, 1}


@pytest.mark.parametrize("changed", sorted(HASHES))
def test_another_runs_folder_is_refused(tmp_path, changed):
    interrupted(tmp_path, [0])
    with pytest.raises(ConfigError, match=rf"another run \(different {changed}\)"):
        RunFolder(tmp_path, HASHES | {changed: "other"}).open()


def test_finished_run_is_complete_and_taken_over(tmp_path):
    interrupted(tmp_path, [0])
    folder = RunFolder(tmp_path, HASHES)
    done = folder.open()
    folder.add(played(1))
    folder.finish([done[0], played(1)], {"hashes": HASHES, "n": 2}, "agent: x\n")
    assert not (tmp_path / PARTIAL).exists()
    assert len((tmp_path / RECORDS).read_text().splitlines()) == 2
    assert json.loads((tmp_path / SUMMARY).read_text())["n"] == 2
    assert RunFolder(tmp_path, HASHES).open() == {0: played(0), 1: played(1)}
    with pytest.raises(ConfigError, match="another run"):
        RunFolder(tmp_path, HASHES | {"code": "new"}).open()


def test_unwritable_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"out=.*file/run: cannot be written"):
        RunFolder(tmp_path / "file" / "run", HASHES).open()
