import json

import pytest

from tests.evaluation.records import played
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation import folder as folder_module
from ucon.evaluation.folder import PARTIAL, RECORDS, SUMMARY, RunFolder, free_folder

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


def test_a_run_of_other_versions_is_not_mixed_in(tmp_path):
    first = RunFolder(tmp_path, HASHES, {"torch": "1"})
    first.open()
    first.add(played(0))
    assert RunFolder(tmp_path, HASHES, {"torch": "1"}).open() == {0: played(0)}
    with pytest.raises(ConfigError, match=r"another run \(different versions\)"):
        RunFolder(tmp_path, HASHES, {"torch": "2"}).open()


def test_seconds_of_interrupted_calls_are_added_up(tmp_path, monkeypatch):
    now = 100.0
    monkeypatch.setattr(folder_module.time, "perf_counter", lambda: now)
    for number, elapsed in enumerate((10.0, 5.0)):
        folder = RunFolder(tmp_path, HASHES)
        folder.open()
        now += elapsed
        folder.add(played(number))
        now += 1000.0  # it hangs, and is killed
    again = RunFolder(tmp_path, HASHES)
    again.open()
    now += 2.0
    assert again.seconds == 17.0


@pytest.mark.parametrize("line", ["{}", '{"index": "x", "seconds": 1}', '{"index": 0}', "[]"])
def test_a_damaged_line_is_named(tmp_path, line):
    partial = interrupted(tmp_path, [0])
    partial.write_text(f"{partial.read_text()}{line}\n")
    with pytest.raises(DataError, match=r"partial:3: no episode with its index and seconds"):
        RunFolder(tmp_path, HASHES).open()


@pytest.mark.parametrize("name", ["config.yaml", "episodes.jsonl", "episodes.jsonl.xz"])
def test_what_is_no_evaluation_that_could_go_on_is_not_overwritten(tmp_path, name):
    """An unfinished training run has a configuration, kept episodes may have lost their summary."""
    (tmp_path / name).write_text("mine")
    with pytest.raises(ConfigError, match=rf"{name} there is of another run and would be overwritten"):
        RunFolder(tmp_path, HASHES).open()
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_free_folder_is_a_new_one_or_that_of_the_same_run_interrupted(tmp_path):
    def free(hashes=HASHES, versions=None):
        return free_folder(tmp_path / "run", hashes, versions or {}).name

    assert free() == "run"
    interrupted(tmp_path / "run", [0])
    assert free() == "run"
    assert free(HASHES | {"code": "new"}) == free(versions={"torch": "2"}) == "run-2"
    (tmp_path / "run" / SUMMARY).write_text("{}")
    assert free() == "run-2"
    (tmp_path / "run-2").mkdir()
    assert free() == "run-2"
    (tmp_path / "run-2" / PARTIAL).write_text("nonsense\n")
    (tmp_path / "run-3").write_text("a file")
    assert free() == "run-4"


def test_unwritable_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"out=.*file/run: cannot be written"):
        RunFolder(tmp_path / "file" / "run", HASHES).open()
