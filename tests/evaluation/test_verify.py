"""``python -m ucon verify``: figures match the records, and older runs can be given checksums."""

import json
import lzma
import shutil
from pathlib import Path

import pytest

from tests.evaluation.records import played, reseal, store
from ucon.__main__ import main
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.seal import RECORDS, SECONDS, SUMMARY, TIMING, has_summary

ROOT = Path(__file__).parents[2]
RESULTS = sorted(
    path.parent for path in (ROOT / "results").glob(f"*/{SUMMARY}") if not path.parent.name.startswith("trained-")
)


@pytest.fixture
def run(tmp_path):
    return store(tmp_path / "run", [played(number, success=number % 2 == 0) for number in range(6)])


def made_older(folder: Path) -> None:
    """Rewrite the folder as the version before checksums wrote it."""
    said, seconds = (json.loads((folder / name).read_text()) for name in (SUMMARY, SECONDS))
    for name in ("files", "checksum"):
        del said[name], seconds[name]
    del seconds["seconds_per_decision"]
    (folder / SUMMARY).write_text(json.dumps(said | seconds, indent=1) + "\n")
    (folder / SECONDS).unlink()


def test_a_run_as_it_was_finished_is_right(run, capsys):
    assert main(["verify", str(run)]) == 0
    assert "6 episodes: " in (told := capsys.readouterr().out)
    assert "figures recomputed, all as stored; the checksums are right; not recomputed: " in told
    assert all(name in told.rpartition(":")[2] for name in ("hashes", "versions", "seconds"))
    assert main(["verify", str(run), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["good"], found["sealed"], found["n"], found["differing"]) == (True, True, 6, [])
    assert {"success_rate", "spl_ci95", "failure_causes", "episode_seconds"} <= set(found["recomputed"])


FIGURES = {
    "success_rate": 0.9,
    "spl_ci95": [0.1, 0.2],
    "steps": 1.0,
    "failure_causes": {},
    "agent": "other",
    "opens": None,
}


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_that_is_not_what_the_records_say_is_named(name, run, capsys):
    reseal(run, **{name: FIGURES[name]})
    assert main(["verify", str(run)]) == 1
    assert f"1 figures are not what the records say ({name})" in capsys.readouterr().out
    before = (run / SUMMARY).read_bytes()
    assert main(["verify", str(run), "--seal"]) == 1
    assert (run / SUMMARY).read_bytes() == before


def test_one_that_cannot_be_read_does_not_keep_others_from_it(run, tmp_path, capsys):
    assert main(["verify", str(tmp_path / "nothing"), str(run)]) == 1
    out, err = capsys.readouterr()
    assert out.count("\n") == err.count("\n") == 1


def test_an_older_run_is_refused_until_it_is_sealed(run, tmp_path, capsys):
    again = shutil.copytree(run, tmp_path / "again")
    made_older(run)
    for words in (("compare", run, again), ("replay", run), ("compare", run / RECORDS, again)):
        assert main(list(map(str, words))) != 0
        assert (
            f"no checksums (written by an older version); `python -m ucon verify {run} --seal`"
            in capsys.readouterr().err
        )
    assert main(["verify", str(run)]) == 1
    assert "there are no checksums: --seal adds them" in capsys.readouterr().out
    assert main(["verify", str(run), "--seal"]) == 0
    assert main(["compare", str(run), str(again)]) == 0
    assert (run / SUMMARY).read_bytes() == (again / SUMMARY).read_bytes()
    assert (run / SECONDS).read_bytes() == (again / SECONDS).read_bytes()


def test_an_older_run_that_is_altered_is_not_sealed(run, capsys):
    made_older(run)
    records = run / RECORDS
    records.write_text(records.read_text().replace('"opens":1', '"opens":2', 1))
    before = {path: path.read_bytes() for path in run.iterdir()}
    assert main(["verify", str(run), "--seal"]) == 1
    assert "not what the records say (opens)" in capsys.readouterr().out
    assert {path: path.read_bytes() for path in run.iterdir()} == before


def test_what_was_taken_away_or_packed_is_sealed_anew(run, capsys):
    raw = (run / RECORDS).read_bytes()
    (run / f"{RECORDS}.xz").write_bytes(lzma.compress(raw))
    (run / RECORDS).unlink()
    assert main(["verify", str(run)]) == 0, "packing changes nothing"
    (run / TIMING).unlink()
    assert main(["verify", str(run)]) == 1
    assert "missing, but seconds.json has its checksum" in capsys.readouterr().err
    assert main(["verify", str(run), "--seal"]) == 0
    assert main(["verify", str(run)]) == 0
    (run / f"{RECORDS}.xz").unlink()
    assert main(["verify", str(run), "--seal"]) == 0
    assert "figures alone, no records to recompute them from; the checksums are right" in capsys.readouterr().out


def test_a_file_of_another_run_is_refused(run, capsys):
    (run / "decisions.jsonl").write_text("")
    assert main(["verify", str(run)]) == 1
    assert "not part of the run that summary.json describes" in capsys.readouterr().err


def test_a_run_of_training_is_none(capsys):
    assert main(["verify", str(ROOT / "results" / "trained-equal-vtn"), "--seal"]) == 1
    assert "no summary of a finished run of eval.py" in capsys.readouterr().err


def test_shipped_results_have_their_checksums():
    assert len(RESULTS) > 90
    assert all(has_summary(folder) and FinishedRun.read(folder).summary["n"] > 0 for folder in RESULTS)
    assert main(["verify", *map(str, [folder for folder in RESULTS if (folder / f"{RECORDS}.xz").is_file()][:2])]) == 0


@pytest.mark.slow
def test_shipped_results_are_what_their_records_say():
    assert main(["verify", *map(str, RESULTS)]) == 0
