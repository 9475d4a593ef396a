"""The worked example of the README and of docs/own_home.md: a flat of two rooms, three sentences, one lost mug."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import main
from ucon.envs.own_home import EXAMPLE
from ucon.evaluation.kept.record import read_records
from ucon.sim.cache import load_house
from ucon.task.own_home.reading import read_home

ROOT = Path(__file__).parents[2]
README, PAGE = (ROOT / "README.md").read_text(), (ROOT / "docs" / "own_home.md").read_text()
SECTION = README[README.index("## Your own home\n") : README.index("## In five lines")]


def blocks(kind: str, text: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL)


def run(*words: str, cache: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in the clone, with its own cache."""
    env = os.environ | {"UCON_CACHE": str(cache), "COLUMNS": "140"}
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder in which the README's commands were run as printed, and their output."""
    folder, told = tmp_path_factory.mktemp("home"), ""
    for line in blocks("bash", SECTION)[0].splitlines():
        program, *words = line.partition("#")[0].replace("my_home.yaml", str(folder / "my_home.yaml")).split()
        assert program == "python"
        more = [f"out={folder / 'runs'}", "pictures=0"] if "eval.py" in words else []
        done = run(*words, *more, cache=folder / "cache")
        assert done.returncode == 0, done.stderr
        told += done.stdout + done.stderr
    return folder, told


def test_the_mug_is_found_as_the_readme_says(played: tuple[Path, str]) -> None:
    steps = {}
    for level in ("none", "retrieval"):
        (record,) = read_records(played[0] / "runs" / f"agent-belief+habit_level-{level}")
        assert record.success
        steps[level] = record.steps
    assert f"found after {steps['none']} steps without its habits, after {steps['retrieval']} with them" in SECTION
    assert f"after {steps['none']} steps without habits, and after {steps['retrieval']} with" in PAGE
    assert steps["retrieval"] < steps["none"]


def test_what_is_built_is_told_as_the_page_says(played: tuple[Path, str]) -> None:
    check = PAGE[PAGE.index("my flat: a flat of ") :].partition("```")[0]
    assert check in played[1]
    assert re.search(r"my_home\.yaml: own:my_flat:\w{12}, 1 search: mug in the top cabinet\n", played[1])


@pytest.mark.slow
def test_runs_are_played_again_and_watched(played: tuple[Path, str]) -> None:
    """In other processes, from the home's file; if the file is missing or changed, the command says so."""
    folder, cache = played[0], played[0] / "cache"
    kept = folder / "runs" / "agent-belief+habit_level-retrieval"
    again = run("-m", "ucon", "replay", str(kept), "--out", str(folder / "again"), cache=cache)
    assert "1 episodes played: the same to the byte" in again.stdout, again.stderr
    assert run("-m", "ucon", "verify", str(kept), cache=cache).returncode == 0
    assert "mug" in run("-m", "ucon", "watch", str(kept), cache=cache).stdout
    shutil.move(folder / "my_home.yaml", folder / "gone.yaml")
    lost = run("-m", "ucon", "replay", str(kept), "--out", str(folder / "lost"), cache=cache)
    shutil.move(folder / "gone.yaml", folder / "my_home.yaml")
    assert lost.returncode == 1
    (line,) = [line for line in lost.stderr.splitlines() if "not played" in line]
    assert "my_home.yaml: cannot be read (No such file or directory)" in line
    text = (folder / "my_home.yaml").read_text()
    (folder / "my_home.yaml").write_text(text.replace("  - mug\n", "  - mug: in the fridge\n"))
    for command in (["watch", str(kept), "0"], ["replay", str(kept)]):
        changed = run("-m", "ucon", *command, "--out", str(folder / "changed"), cache=cache)
        assert re.search("other episodes (are kept|were played) than", changed.stdout + changed.stderr)
    (folder / "my_home.yaml").write_text(text)


def test_the_page_prints_the_example() -> None:
    lines = [line.partition("  #")[0].rstrip() for line in EXAMPLE.read_text().splitlines() if not line.startswith("#")]
    assert [line for line in lines if line] == blocks("yaml", PAGE)[0].splitlines()
    assert len(read_home(EXAMPLE).requests[0].habits) == 3


@pytest.mark.parametrize("code", blocks("python", PAGE))
def test_python_of_the_page_runs(code: str, tmp_path: Path) -> None:
    done = run("-c", code, cache=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("mug\n- ")
    assert "- My sister hides her mug in the top cabinet.\n" in done.stdout


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    load_house.cache_clear()
    return tmp_path / "my_home.yaml"


def test_a_file_is_never_written_over(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["home", "new", str(file)]) == 0
    file.write_text("mine")
    assert main(["home", "new", str(file)]) == 2
    assert file.read_text() == "mine"
    assert main(["home", "new", str(file.with_suffix(".txt"))]) == 2
    assert "expected a name that ends in .yaml" in capsys.readouterr().err


def test_json_and_a_plan(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    furniture = "{fridge: 1, countertop: 1, sink: 1, top cabinet: 1, piano: 1}"
    file.write_text(
        f"rooms:\n  kitchen:\n    size: [2, 2.5]\n    furniture: {furniture}\n"
        "habits: [The mug is in the fridge.]\nrequests: [mug: in the fridge]\n"
    )
    assert main(["home", "check", str(file), "--json", "--plan", str(file.with_suffix(".png"))]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rooms"][0]["room"] == "kitchen"
    assert found["requests"][0]["place"] == "in the fridge"
    assert found["requests"][0]["chance_by_habits"] is None
    assert any(line.startswith(f"{file}:4: kitchen: piano: it does not fit; ") for line in found["not placed"])
    assert file.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert main(["home", "check", str(file)]) == 0
    assert f"warning: {file}:4: kitchen: piano: it does not fit" in capsys.readouterr().err


def test_faults_of_a_file_are_the_commands_error(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["home", "check", str(file)]) == 2
    file.write_text("rooms: {kitchen: {furniture: {frigde: 1}}}\n")
    assert main(["home", "check", str(file)]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told[0].startswith(f"error: {file}: cannot be read")
    assert told[1].startswith(f"error: {file}:1: unknown furniture 'frigde': did you mean fridge")


@pytest.mark.slow
def test_a_home_file_is_packed_for_machines_without_pybullet(file: Path, tmp_path: Path) -> None:
    shutil.copy(EXAMPLE, file)
    pack = tmp_path / "pack"
    assert main(["pack", str(file), "--out", str(pack)]) == 0
    assert main(["pack", str(file)]) == 2
    (tmp_path / "pybullet.py").write_text("raise ImportError('not here')")
    play = (
        "import sys, gymnasium as gym, ucon\nfrom ucon.core.errors import UconError\ntry:\n"
        "    env = gym.make('UcON-v0', episodes=sys.argv[1], observe='symbolic')\n    print(env.reset()[1]['target'])\n"
        "except UconError as error:\n    print(error)"
    )
    missing = r"home 'own:my_flat:\w+': .*PyBullet.*is missing here.*\n"
    for chosen, told in (({"UCON_PACK": str(pack)}, "mug\n"), ({}, missing)):
        there = {"UCON_CACHE": str(tmp_path / "empty"), "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"} | chosen
        command = [sys.executable, "-c", play, str(file)]
        done = subprocess.run(command, env=os.environ | there, capture_output=True, text=True, timeout=120)
        assert re.fullmatch(told, done.stdout), (done.stdout, done.stderr)


def test_other_habits_than_those_of_the_file_are_refused(file: Path) -> None:
    from ucon.core.errors import ConfigError
    from ucon.programs.composing import eval_config
    from ucon.programs.evaluating import with_own_habits

    config = eval_config(f"episodes={file}")
    own = with_own_habits(config)
    assert own["env"]["source"]["dataset"] == {"_target_": "ucon.configuration.wiring.folder_habits", "path": str(file)}
    assert with_own_habits(own) == own
    other = eval_config("episodes=mini")
    assert with_own_habits(other) == other
    with pytest.raises(ConfigError, match="has its own habits; leave out habits="):
        with_own_habits(eval_config(f"episodes={file}", "habits=official", "habits.path=x.json"))


def test_all_faults_are_told_at_once_by_line(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Including faults that only show once the home is built, and furniture that does not fit."""
    file.write_text(
        "rooms:\n  bedroom:\n    size: [2, 2]\n    furniture: {bed: 3, piano: 1}\n"
        "  kitchen:\n    size: [3.5, 4]\n    furniture: {microwave: 1, countertop: 2, fridge: 1}\n"
        "habits: [The bicycle is kept in the microwave., The mug is on the moon.]\n"
        "requests:\n  - mug: on the moon\n  - bicycle: in the microwave\n  - teapot: in the bed\n"
    )
    assert main(["home", "check", str(file)]) == 2
    warning, head, *faults = capsys.readouterr().err.replace(f"{file}:", "").splitlines()
    assert warning.startswith("warning: 4: bedroom: bed: none of the 3 fit; ")
    assert head == "error:  4 faults:"
    assert [re.split("[;(?]", fault)[0].strip() for fault in faults] == [
        "10: mug: unknown thing 'moon': did you mean money, lemon, salmon",
        "11: the bicycle cannot be kept in the microwave",
        "12: teapot: nothing is inside a bed",
        "12: no sentence of 'habits' is about the teapot",
    ]
