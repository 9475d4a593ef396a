"""``eval.py`` from end to end, in separate processes."""

import functools
import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.evaluation.records import reseal
from tests.language.tiny_models import save_causal
from ucon.core.errors import ConfigError
from ucon.evaluation.kept.record import read_records
from ucon.programs.evaluating import chosen_episodes
from ucon.programs.sweep import folder_name

ROOT = Path(__file__).parents[1]
QUICK = ("episodes=mini", "limit=4", "pictures=0", "progress=false")


def evaluate(*overrides: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "eval.py", *overrides]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "frontier"
    result = evaluate("agent=frontier", "habit_level=none", *QUICK, f"out={out}")
    assert result.returncode == 0, result.stderr[-2000:]
    return out, result


def test_writes_what_scripts_rely_on(run):
    out, result = run
    summary = json.loads((out / "summary.json").read_text())
    assert set(summary) >= {
        "success_rate",
        "spl",
        "n",
        "success_rate_ci95",
        "spl_ci95",
        "hashes",
        "versions",
    }
    assert set(summary["hashes"]) == {"config", "episodes", "habits", "code", "weights"}
    assert all(len(value) == 64 for value in summary["hashes"].values())
    assert summary["n"] == 4 == len(read_records(out))
    assert "frontier" in result.stdout
    assert "_target_: models.agents.frontier.FrontierAgent" in (out / "config.yaml").read_text()
    assert not (out / "episodes.jsonl.partial").exists()


def test_the_released_rules_have_shortest_paths_of_their_own(tmp_path):
    out = tmp_path / "released"
    command = ("agent=oracle", "habit_level=none", "task=released_code", "episodes=mini", "pictures=0", f"out={out}")
    result = evaluate(*command, "progress=false")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "warning" not in result.stderr
    summary = json.loads((out / "summary.json").read_text())
    assert summary["n"] == 50
    assert summary["success_rate"] == 1.0
    assert summary["spl"] >= 0.99


def test_a_file_made_under_other_rules_is_warned_of(tmp_path):
    file = "episodes=ucon/task/data/mini.jsonl.xz"
    result = evaluate("agent=random", "habit_level=none", "task=released_code", *QUICK, file, f"out={tmp_path}/other")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "warning: episodes made under task=paper, played under task=released_code" in result.stderr


def test_a_second_run_gives_the_same_bytes(run, tmp_path):
    result = evaluate("agent=frontier", "habit_level=none", *QUICK, "workers=0", f"out={tmp_path}/again")
    assert result.returncode == 0, result.stderr[-2000:]
    assert (tmp_path / "again" / "episodes.jsonl").read_bytes() == (run[0] / "episodes.jsonl").read_bytes()


def test_a_finished_run_is_not_played_again_and_stays_as_it_is(run):
    reseal(run[0], versions={"torch": "of then"})
    before = {path: path.read_bytes() for path in run[0].iterdir()}
    result = evaluate("agent=frontier", "habit_level=none", *QUICK, f"out={run[0]}")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "for 0 episodes" in result.stdout
    assert {path: path.read_bytes() for path in run[0].iterdir()} == before


@pytest.mark.slow
def test_a_finished_run_is_printed_without_the_weights_that_made_it(tmp_path):
    """Missing weights stop a run before it begins, changed ones make another run; finished results need no weights."""
    folder, out = save_causal(tmp_path / "llama", positions=2048), tmp_path / "run"
    made = ("agent=lgx", "language=causal_lm", f"language.path={folder}", "habit_level=none", "language.dtype=float32")
    command = (*made, "language.device=cpu", "episodes=mini", "limit=1", "pictures=0", "workers=0", "progress=false")
    first = evaluate(*command, f"out={out}")
    assert first.returncode == 0, first.stderr[-2000:]
    assert json.loads((out / "summary.json").read_text())["language_model"] == "causal (llama)"
    weights = folder / "model.safetensors"
    whole = weights.read_bytes()
    weights.write_bytes(whole[:-4] + b"\x01\x02\x03\x04")
    other = evaluate(*command, f"out={out}")
    assert other.returncode == 2
    assert "belongs to another run (different weights)" in other.stderr
    shutil.rmtree(folder)
    again = evaluate(*command, f"out={out}")
    assert again.returncode == 0, again.stderr[-2000:]
    assert "for 0 episodes" in again.stdout
    assert len(json.loads((out / "summary.json").read_text())["hashes"]["weights"]) == 64
    fresh = evaluate(*command, f"out={tmp_path}/fresh")
    assert fresh.returncode == 2
    assert "no such folder, and no model of that name" in fresh.stderr
    assert not list((tmp_path / "fresh").iterdir())


def test_a_part_of_a_set_is_spread_over_it():
    whole = chosen_episodes("mini", None, "paper", context=False)
    assert chosen_episodes("mini", None, "paper", context=False, every=7) == whole[::7]
    assert chosen_episodes("mini", 3, "paper", context=False, every=7) == whole[:21:7]
    for nonsense in (0, -1, 1.5, "two", True):
        with pytest.raises(ConfigError, match="every="):
            chosen_episodes("mini", None, "paper", context=False, every=nonsense)


def test_another_run_is_refused_its_folder(run):
    result = evaluate("agent=random", "habit_level=none", *QUICK, f"out={run[0]}")
    assert result.returncode == 2
    assert "belongs to another run (different config)" in result.stderr


def test_an_interrupted_run_goes_on(tmp_path):
    out = tmp_path / "run"
    overrides = ("agent=frontier", "habit_level=none", "limit=12", "pictures=0", "progress=false", f"out={out}")
    process = subprocess.Popen(
        [sys.executable, "eval.py", *overrides],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=functools.partial(
            signal.signal, signal.SIGINT, signal.SIG_DFL
        ),  # a shell's background jobs ignore Ctrl-C
    )
    partial = out / "episodes.jsonl.partial"
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline and not (partial.is_file() and partial.read_text().count("\n") > 2):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert stderr.strip().splitlines()[-1].startswith("error: interrupted")
    kept = partial.read_text().count("\n") - 1
    result = evaluate(*overrides)
    assert result.returncode == 0, result.stderr[-2000:]
    assert f"for {12 - kept} episodes" in result.stdout
    whole = evaluate(*overrides[:-1], f"out={tmp_path}/whole")
    assert whole.returncode == 0
    assert (out / "episodes.jsonl").read_bytes() == (tmp_path / "whole" / "episodes.jsonl").read_bytes()


@pytest.mark.slow
def test_context_is_the_same_bytes_with_any_workers(tmp_path):
    levels = ("agent=belief", "episodes=mini", "limit=3", "pictures=0", "progress=false")
    result = evaluate("-m", *levels, "habit_level=retrieval,context", "workers=2", f"out={tmp_path}/sweep")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "belief context - belief retrieval" in result.stdout
    alone = evaluate(*levels, "habit_level=context", "workers=0", f"out={tmp_path}/alone")
    assert alone.returncode == 0, alone.stderr[-2000:]
    swept = next((tmp_path / "sweep").glob("*context*/episodes.jsonl"))
    assert swept.read_bytes() == (tmp_path / "alone" / "episodes.jsonl").read_bytes()


@pytest.mark.slow
def test_a_sweep_over_sets_keeps_them_apart(tmp_path):
    """Folders are named by the overrides, or by the set alone."""
    for overrides, before in ((("agent=frontier",), "agent-frontier+"), ((), "")):
        folder = tmp_path / f"sweep{len(overrides)}"
        result = evaluate("-m", *overrides, "episodes=mini,val", "limit=2", "workers=0", f"out={folder}")
        assert result.returncode == 0, result.stderr[-2000:]
        assert {path.name for path in folder.iterdir() if path.is_dir()} == {
            f"{before}episodes-{name}" for name in ("mini", "val")
        }
        for name in ("mini", "val"):
            rows = (folder / f"{before}episodes-{name}" / "episodes.jsonl").read_text().splitlines()
            assert {json.loads(row)["episode"].split("/")[0] for row in rows} == {name}
            assert f"{name} " in "".join(line for line in result.stdout.splitlines() if line.startswith(f"{folder}"))


def test_files_of_one_name_have_folders_of_their_own():
    assert folder_name("mini") == "mini"
    one, other = folder_name("a/test.jsonl.xz"), folder_name("b/test.jsonl.xz")
    assert one != other
    assert one.startswith("test-")
    assert folder_name("my.home.yaml").startswith("my.home-")


def test_a_sweep_ends_in_a_comparison_and_plays_once_who_reads_no_habits(tmp_path):
    sweep = ("-m", "agent=frontier_nearest,lgx", "habit_level=none,gt", *QUICK[:-1], f"out={tmp_path}/sweep")
    result = evaluate(*sweep)
    assert result.returncode == 0, result.stderr[-2000:]
    runs = {path.parent: json.loads(path.read_text()) for path in (tmp_path / "sweep").glob("*/summary.json")}
    assert sorted((s["agent"], s["habit_level"]) for s in runs.values()) == [
        ("frontier_nearest", "none"),
        ("lgx", "gt"),
        ("lgx", "none"),
    ]
    for label in ("frontier_nearest none", "lgx + encoder (all-MiniLM-L6-v2) gt"):  # named as in the tables
        assert f"{label}: 0 of 4 episodes\n" in result.stderr
    assert result.stdout.count("frontier_nearest reads no habits: its results are those in") == 1
    assert "paired differences" in result.stdout
    for level in ("none", "gt"):  # an agent without habits is compared with every level
        assert f"lgx + encoder (all-MiniLM-L6-v2) {level} - frontier_nearest any" in result.stdout
    for folder, found in runs.items():
        made = (folder / "decisions.jsonl").read_text().splitlines()
        assert len(made) > 4
        assert found["detector"] == "gt"
        assert found["uses_habits"] == (found["agent"] == "lgx")
        assert found["language_model"] == ("encoder (all-MiniLM-L6-v2)" if found["agent"] == "lgx" else None)
        if found["agent"] == "lgx":
            assert found["language"]["decisions"] == len(made)
            assert found["language"]["fallback_rate"] == 0.0
        else:
            assert found["language"] is None


def test_a_run_by_itself_is_played_whatever_lies_beside_it(run):
    beside = run[0].parent / "beside"
    result = evaluate("agent=frontier", "habit_level=none", *QUICK, "workers=0", f"out={beside}")
    assert result.returncode == 0, result.stderr[-2000:]
    assert (beside / "episodes.jsonl").read_bytes() == (run[0] / "episodes.jsonl").read_bytes()
