"""docs/EXTENDING.md: its worked example does what it says, with only the two files that it names."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "EXTENDING.md").read_text()
FILES = dict(re.findall(r"`([\w/.]+)`:\n\n```(?:python|yaml)\n(.*?)```", PAGE, re.DOTALL))


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """The scripts, with the example's files added."""
    folder = tmp_path_factory.mktemp("clone")
    for name in ("configs", "models"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "eval.py", folder)
    assert set(FILES) == {"models/agents/mentioned.py", "configs/agent/mentioned.yaml"}
    for name, text in FILES.items():
        assert not (folder / name).exists()
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize("check", [["check"], ["format", "--check"]])
def test_the_example_is_written_as_the_project_writes(clone, check):
    command = [sys.executable, "-m", "ruff", *check, "--config", str(ROOT / "pyproject.toml")]
    command += ["--config", 'lint.isort.known-first-party=["models", "ucon"]'] if check == ["check"] else []
    done = subprocess.run([*command, "models/agents/mentioned.py"], cwd=clone, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_example_plays_and_reads_habits(clone):
    chosen = {}
    for level in ("none", "gt"):
        command = [sys.executable, "eval.py", "agent=mentioned", f"habit_level={level}", "episodes=mini", "limit=6"]
        options = [f"out={clone / level}", "workers=0", "pictures=0", "progress=false"]
        library = os.environ | {"PYTHONPATH": str(ROOT)}  # the same package, so that its kernels are already compiled
        subprocess.run([*command, *options], cwd=clone, env=library, check=True, capture_output=True, text=True)
        summary = json.loads((clone / level / "summary.json").read_text())
        assert summary["agent"] == "mentioned"
        assert summary["n"] == 6
        played = [json.loads(line) for line in (clone / level / "episodes.jsonl").read_text().splitlines()]
        assert not [episode for episode in played if re.search("2{13}|1{13}", episode["actions"])]
        lines = (clone / level / "decisions.jsonl").read_text().splitlines()
        chosen[level] = [(d["episode"], d["number"], d["chosen"]) for d in map(json.loads, lines)]
    assert chosen["none"] != chosen["gt"]


@pytest.mark.parametrize(
    ("habit", "category", "mentions"),
    [
        ("The bedroom is tidied, and the bedside lamp stays.", "bed", 0),
        ("My BED: the bed-cover lies on the bed.", "bed", 3),
        ("A coffee table; the coffee tables.", "coffee_table", 1),
        ("Nothing.", "", 0),
    ],
)
def test_the_example_counts_whole_words(habit, category, mentions):
    made = {"__name__": "mentioned"}
    exec(compile(FILES["models/agents/mentioned.py"], "mentioned.py", "exec"), made)
    agent = made["MentionedAgent"](weight=1.0)
    agent.start(0, {"habits": (habit,)})
    assert agent._score(SimpleNamespace(category=category, cost=0), agent._words[0]) == mentions


@pytest.mark.slow
def test_the_tests_that_the_page_names_are_of_the_example(clone):
    (line,) = re.findall(r"^python -m (pytest .*)$", PAGE, re.MULTILINE)
    shutil.copytree(ROOT / "tests", clone / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and not (clone / path.name).exists():
            (clone / path.name).symlink_to(path)
    command = [sys.executable, "-m", *line.split(), "-rp", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=clone, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    played = re.findall(r"^PASSED \S+::(\w+)\[\S*mentioned", done.stdout, re.MULTILINE)
    assert len(set(played)) >= 4


def test_every_file_that_the_page_names_is_there():
    for name in re.findall(r"`((?:models|configs|ucon|docs)/[\w/.]+)`", PAGE):
        assert name in FILES or (ROOT / name).exists(), name
