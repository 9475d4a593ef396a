"""The command line as a user runs it, each command in its own process."""

import json
import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import COMMANDS, main
from ucon.commands.doctor import read_pins

ROOT = Path(__file__).parents[2]


def run(
    *words: str, script: tuple[str, ...] = ("-m", "ucon"), cwd: Path = ROOT, timeout: float = 120
) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *script, *words], cwd=cwd, capture_output=True, text=True, timeout=timeout)


def user_error(result: subprocess.CompletedProcess[str]) -> str:
    """The one line that a user's mistake ends in."""
    lines = result.stderr.strip().splitlines()
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_help_names_every_command_in_less_than_half_a_second():
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = run("--help")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert result.returncode == 0
    assert all(name in result.stdout for name in COMMANDS)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 0.5


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_without_heavy_imports(command):
    code = (
        "import sys; from ucon.__main__ import main\n"
        f"try: main(['{command}', '--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'torch', 'numba', 'pybullet', 'transformers', 'gymnasium', 'numpy'} & set(sys.modules)))"
    )
    result = run(code, script=("-c",))
    assert f"usage: ucon {command}" in result.stdout, result.stderr
    assert result.stdout.strip().endswith("[]")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["doctr"], "did you mean doctor"),
        (["compare", "nowhere", "else"], r"nowhere/episodes\.jsonl: no such file|nowhere: no such file"),
        (["compare", "one"], "at least two"),
        (["habits", "import", "nowhere.json", "--json"], r"nowhere\.json"),
        (["habits", "import", "pyproject.toml", "--all"], "--all: pyproject.toml is a file"),
        (["habits", "import", "configs", "--all"], "configs: no task file of the release in it"),
        (["habits", "import", "configs"], r"no seen_obj_seen_scene\.json in it, found no task file at all"),
        (["scenes", "--scene", "Rs_imt"], "Rs_int"),
        (["episodes", "verify", "nowhere"], "nowhere"),
        (["episodes", "make", "mini", "--task", "papr"], "did you mean paper"),
        (["episodes", "make", "mini", "--limit", "1", "--task", "papr"], "--limit without --out: set 'mini' itself"),
        (["episodes", "make", "official", "--limit", "1", "--habits", "nowhere.json"], "--limit without --out"),
        (["episodes", "make", "mini", "--habits", "nowhere.habits.xz"], "--habits without --out: set 'mini' itself"),
    ],
)
def test_mistakes_end_in_one_line(words, expected):
    assert re.search(expected, user_error(run(*words)))


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (["--agent", "frontier"], "options are given as name=value"),
        (["agent=fronteir"], "did you mean frontier"),
        (["habit_level=retreival"], "did you mean retrieval"),
        (["limti=3"], "did you mean limit"),
        (["env.hieght_px=3"], r"did you mean env\.height_px"),
        (["habits=official"], r"give habits\.path="),
        (["agent=random", "habits=official", "habits.path=nowhere", "limit=1"], "nowhere: no such file"),
        (["episodes=nowhere"], "nowhere"),
        (["limit=0"], "from 1 up"),
        (["batch=0"], "batch=0: expected a whole number from 1 up"),
        (["batch=-1"], "batch=-1"),
        (["batch=x"], "batch=x"),
        (["workers=many", "limit=1"], "workers=many"),
        (["limit=[1"], "cannot read 'limit=\\[1'"),
        (["task=papper"], "did you mean paper"),
    ],
)
def test_eval_mistakes_end_in_one_line(overrides, expected, tmp_path):
    result = run(*overrides, f"out={tmp_path}/run", "progress=false", script=("eval.py",))
    assert re.search(expected, user_error(result))


def test_pins_follow_this_python():
    pins = read_pins(ROOT / "constraints.txt")
    assert pins["torch"] == "2.13.0"
    assert len([name for name in pins if name == "numpy"]) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "names"),
    [
        (
            ["bench", "--json"],
            "renderer_ratio_128 renderer_ratio_128_flat renderer_ratio_224 env_pixels_sps env_symbolic_sps "
            "env_with_resets_sps decisions_per_s search_decisions_per_s search_decisions_per_s_worst "
            "search_steps_per_decision",
        ),
        (
            ["habits", "stats", "--json"],
            "habits categories vocabulary distinct_2 unique_masked duplicates near_duplicates mrr recall_at_20",
        ),
    ],
)
def test_names_that_scripts_rely_on(words, names):
    command = [sys.executable, "-m", "ucon", *words]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=900)
    assert result.returncode == 0, result.stderr
    assert set(names.split()) <= set(json.loads(result.stdout))


def test_what_an_imported_file_holds_and_what_of_it_can_be_placed(tmp_path):
    locations = ["mug.place_ontop(breakfast_table)", "mug.place_inside(walls)", "mug.place_nextto(swing)", "mug"]
    task = {"basic_object_name": "mug", "habits": ["Keeps it on the table."], "location": locations}
    (tmp_path / "tasks.json").write_text(json.dumps({"Rs_int": {"mug": [task]}}))
    result = run("habits", "import", str(tmp_path / "tasks.json"), "--json", "--static")
    assert result.returncode == 1, "something was malformed"
    found = json.loads(result.stdout)
    counts = {name: value for name, value in found.items() if not isinstance(value, list)}
    assert counts == {
        **{"scenes": 1, "categories": 1, "tasks": 1, "habits": 1, "locations": 4},
        **{"placed": 1, "imported": 0, "implausible": 1, "absent_anchor": 1, "never_seen": 0, "malformed": 1},
    }
    where = [one["where"].rpartition("tasks.json: ")[2] for one in found["problems"] + found["unplaced"]]
    assert where == [f"Rs_int > mug[0].location[{k}]" for k in (3, 1, 2)]


def test_all_files_of_a_folder_are_reported_each_by_itself(tmp_path):
    task = {"basic_object_name": "mug", "habits": ["Keeps it on the table."], "location": ["mug.place_ontop(shelf)"]}
    for name in ("task.json", "test.json"):
        (tmp_path / name).write_text(json.dumps({"Rs_int": [task]}))
    (tmp_path / "task_nodoor.json").write_text("[" * 50_000)
    result = run("habits", "import", str(tmp_path), "--all", "--static", "--json")
    assert result.returncode == 1, result.stderr
    found = json.loads(result.stdout)
    assert {name: file["placed"] for name, file in found["files"].items()} == {"task.json": 1, "test.json": 1}
    assert [line.partition("task_nodoor.json")[2][:18] for line in found["unusable"]] == [": nested deeper th"]
    assert any("seen_obj_seen_scene.json: missing" in line for line in found["warnings"])
    shown = run("habits", "import", str(tmp_path), "--all", "--static")
    assert "== test.json" in shown.stdout
    assert "unusable:" in shown.stdout
    assert "warnings:" in shown.stdout


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (["catalogue", "--category", "mug", "--json"], "1 categories"),
        (["scenes", "--scene", "Rs_int", "--json"], "1 homes"),
    ],
)
def test_a_sheet_is_named_with_what_is_on_it(words, what, tmp_path, capsys):
    sheet = tmp_path / "sheet.png"
    assert main([*words, "--sheet", str(sheet)]) == 0
    told = capsys.readouterr()
    assert told.err == f"{sheet}: {what}, {sheet.stat().st_size / 1024:.0f} KB\n"
    assert len(json.loads(told.out)) == 1
