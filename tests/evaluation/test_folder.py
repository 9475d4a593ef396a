import json

import pytest

from tests.evaluation.records import played
from ucon.core.errors import ConfigError, DataError, UconError
from ucon.core.files import sha256_bytes
from ucon.evaluation.figures.report import summary
from ucon.evaluation.kept import folder as folder_module
from ucon.evaluation.kept.folder import RunFolder, free_folder
from ucon.evaluation.kept.partial import line_of, line_of_played
from ucon.evaluation.kept.seal import PARTIAL, RECORDS, SUMMARY

IDS = [f"e{number}" for number in range(3)]
HASHES = {"config": "c", "episodes": "e", "habits": "h", "code": "v"}


def interrupted(path, numbers):
    folder = RunFolder(path, HASHES)
    folder.open(IDS)
    for number in numbers:
        folder.add(played(number))
    return path / PARTIAL


def test_goes_on_where_it_was_interrupted(tmp_path):
    interrupted(tmp_path, [2, 0])
    assert RunFolder(tmp_path, HASHES).open(IDS) == {0: played(0), 2: played(2)}


def test_a_line_cut_off_in_mid_write_is_played_again(tmp_path):
    partial = interrupted(tmp_path, [0, 1])
    partial.write_text(partial.read_text()[:-30])
    folder = RunFolder(tmp_path, HASHES)
    assert set(folder.open(IDS)) == {0}
    folder.add(played(1))
    assert set(RunFolder(tmp_path, HASHES).open(IDS)) == {0, 1}


@pytest.mark.parametrize("changed", sorted(HASHES))
def test_another_runs_folder_is_refused(tmp_path, changed):
    interrupted(tmp_path, [0])
    with pytest.raises(ConfigError, match=rf"another run \(different {changed}\)"):
        RunFolder(tmp_path, HASHES | {changed: "other"}).open(IDS)


def test_finished_run_is_complete_and_taken_over(tmp_path):
    interrupted(tmp_path, [0])
    folder = RunFolder(tmp_path, HASHES)
    done = folder.open(IDS)
    folder.add(played(1))
    both = [done[0], played(1)]
    folder.finish(both, summary(both, HASHES), "agent: x\n")
    assert not (tmp_path / PARTIAL).exists()
    assert len((tmp_path / RECORDS).read_text().splitlines()) == 2
    assert json.loads((tmp_path / SUMMARY).read_text())["n"] == 2
    assert RunFolder(tmp_path, HASHES).open(IDS[:2]) == {0: played(0), 1: played(1)}
    with pytest.raises(DataError, match="now names other episodes"):
        RunFolder(tmp_path, HASHES).open(IDS)
    with pytest.raises(ConfigError, match="another run"):
        RunFolder(tmp_path, HASHES | {"code": "new"}).open(IDS)


def test_a_run_of_other_versions_is_not_mixed_in(tmp_path):
    first = RunFolder(tmp_path, HASHES, {"torch": "1"})
    first.open(IDS)
    first.add(played(0))
    assert RunFolder(tmp_path, HASHES, {"torch": "1"}).open(IDS) == {0: played(0)}
    with pytest.raises(ConfigError, match=r"another run \(different versions\)"):
        RunFolder(tmp_path, HASHES, {"torch": "2"}).open(IDS)


def test_seconds_of_interrupted_calls_are_added_up(tmp_path, monkeypatch):
    now = 100.0
    monkeypatch.setattr(folder_module.time, "perf_counter", lambda: now)
    for number, elapsed in enumerate((10.0, 5.0)):
        folder = RunFolder(tmp_path, HASHES)
        folder.open(IDS)
        now += elapsed
        folder.add(played(number))
        now += 1000.0  # it hangs and is killed
    again = RunFolder(tmp_path, HASHES)
    again.open(IDS)
    now += 2.0
    assert again.seconds == 17.0


FIRST = line_of({"hashes": HASHES, "versions": {}, "n": len(IDS)})


def whole_line(number, seconds, first=FIRST):
    return line_of_played(played(number), seconds, first)


def lines_of(value, number=0):
    """A correct line, except for the changes in ``value``."""
    line = json.loads(whole_line(number, 1.0).partition(b" ")[2])
    return line_of({**line, **value}, FIRST)


DAMAGED = {
    "no JSON": b"hello\n",
    "no checksum": whole_line(1, 1.0).partition(b" ")[2],
    "another checksum": b"0" + whole_line(1, 1.0)[1:],
    "of another run": whole_line(1, 1.0, line_of({"hashes": {"config": "other"}, "versions": {}})),
    "cut inside a letter": lines_of({}, 1)[:-20] + "\u00e9".encode()[:1] + b"\n",
    "index out of range": lines_of({"index": 999}, 1),
    "index of another episode": lines_of({"index": 2}, 1),
    "index below 0": lines_of({"index": -2}, 1),
    "index that is none": lines_of({"index": True}, 1),
    "an episode twice": lines_of({"seconds": 1.5}, 0),
    "no seconds": lines_of({"seconds": None}, 1),
    "no record": lines_of({"record": {}}, 1),
    "timing of another": lines_of({"timing": json.loads(played(2).timing.to_line())}, 1),
    "decisions that are none": lines_of({"decisions": [[]]}, 1),
    "deeply nested": b" ".join((sha256_bytes(FIRST[:64] + b"[" * 99999).encode(), b"[" * 99999)) + b"\n",
    "one thing more": lines_of({"more": 1}, 1),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_line_costs_its_own_episode_alone(tmp_path, name):
    partial = interrupted(tmp_path, [0])
    whole = partial.read_bytes()
    partial.write_bytes(whole + DAMAGED[name] + whole_line(2, 2.0))
    folder = RunFolder(tmp_path, HASHES)
    assert folder.open(IDS) == {0: played(0), 2: played(2)}
    assert folder.damaged == 1
    assert partial.read_bytes() == whole + whole_line(2, 2.0)
    again = RunFolder(tmp_path, HASHES)
    assert (set(again.open(IDS)), again.damaged) == ({0, 2}, 0)


def test_a_first_line_that_is_damaged_is_refused(tmp_path):
    partial = interrupted(tmp_path, [0, 1])
    whole = partial.read_bytes()
    for bit in range(0, 8 * (whole.index(b"\n") + 1), 7):
        raw = bytearray(whole)
        raw[bit // 8] ^= 1 << bit % 8
        partial.write_bytes(raw)
        with pytest.raises(UconError, match="its first line is damaged"):
            RunFolder(tmp_path, HASHES).open(IDS)
        assert partial.read_bytes() == raw, "nothing is lost"
        assert not RunFolder(tmp_path, HASHES).is_free()


def test_every_place_where_a_write_was_cut_off(tmp_path):
    partial = interrupted(tmp_path, [0, 1])
    raw = partial.read_bytes()
    for size in range(0, len(raw), 37):
        partial.write_bytes(raw[:size])
        folder = RunFolder(tmp_path, HASHES)
        done = folder.open(IDS)
        assert (list(done), folder.damaged) == (list(range(max(0, raw[:size].count(b"\n") - 1))), 0)
        for number in range(len(done), 2):
            folder.add(played(number))
        assert set(RunFolder(tmp_path, HASHES).open(IDS)) == {0, 1}


@pytest.mark.parametrize("name", ["config.yaml", "episodes.jsonl", "episodes.jsonl.xz"])
def test_what_is_no_evaluation_that_could_go_on_is_not_overwritten(tmp_path, name):
    """An unfinished training run has a configuration, and kept episodes may have lost their summary."""
    (tmp_path / name).write_text("mine")
    with pytest.raises(ConfigError, match=rf"{name} belongs to another run and would be overwritten"):
        RunFolder(tmp_path, HASHES).open(IDS)
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
        RunFolder(tmp_path / "file" / "run", HASHES).open(IDS)
