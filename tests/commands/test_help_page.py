"""``--help`` of the scripts: every option with its comment, and every choice of every group."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import DictConfig

from ucon.configuration.help_page import HelpEntry, help_page, options_of

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"


def test_options_are_told_with_their_comments() -> None:
    text = (
        "# What the file is.\n_target_: a.B\n# One,\n# in two lines.\none: 1  # more\nplain: 2\nouter:\n  # Inner.\n"
        "  inner: [a, b]\n  deeper:\n    # Deep.\n    deep: null\n# Last.\nlast:\n  x: 1\n"
    )
    assert list(options_of(text)) == [
        HelpEntry("one", "1", "One, in two lines."),
        HelpEntry("outer.inner", "[a, b]", "Inner."),
        HelpEntry("outer.deeper.deep", "null", "Deep."),
        HelpEntry("last", "...", "Last."),
    ]


def test_code_keeps_its_lines() -> None:
    text = "# The file.\n\n# One, as\n# in:\n#   a=1\n#   b=2\n# Then more.\none: 1\n"
    assert list(options_of(text)) == [HelpEntry("one", "1", "One, as in:\n  a=1\n  b=2\nThen more.")]
    page = help_page(CONFIGS, "eval")
    yolo, bge = (page[page.index(f"\n  {name} ") + 1 :].splitlines() for name in ("yolo_world", "bge_m3"))
    commands = [line[3:].strip() for line in (CONFIGS / "detector/yolo_world.yaml").read_text().splitlines()[1:4]]
    assert [line.strip() for line in yolo[3:6]] == commands
    assert [line.split()[0] for line in bge[:4]] == ["bge_m3", "own;", "retriever=bge_m3", "bm25"]


@pytest.mark.parametrize("name", ["eval", "train"])
def test_every_choice_of_every_group_is_there(name: str) -> None:
    page = help_page(CONFIGS, name)
    lines = page.splitlines()
    code = {line[1:].strip() for path in CONFIGS.rglob("*.yaml") for line in path.read_text().splitlines()}
    assert [line for line in lines if len(line) > 80 and line.strip() not in code] == []
    starts = {line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "}
    for group in ("agent", "detector", "habits", "retriever", "language"):
        assert any(line.startswith(f"{group}=") for line in lines)
        assert {path.stem for path in (CONFIGS / group).glob("*.yaml")} <= starts
    assert {"seed=0", "progress=true"} <= starts
    assert not [line for line in lines if "_target_" in line or "hydra" in line]


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("agent/*.yaml")), ids=lambda path: path.stem)
def test_a_choice_adds_its_own_options(path: Path) -> None:
    page = help_page(CONFIGS, "eval", [f"agent={path.stem}", "agent=../../etc", "x=y", "--help"])
    told = page.partition(f"Options of agent={path.stem}:")[2]
    assert page.count("Options of ") == 1
    whole = path.read_text().startswith("# @package _global_")
    assert all(f"  {'' if whole else 'agent.'}{option.name}=" in told for option in options_of(path.read_text()))


@pytest.mark.parametrize(
    ("choice", "option"),
    [
        ("task=real_robot", "env.rig.camera_m"),
        ("part=clip", "agent.policy.clip.path"),
        ("detector=noisy", "detector.errors"),
        ("habits=folder", "habits.path"),
    ],
)
def test_options_of_a_choice_have_the_names_by_which_they_are_given(choice: str, option: str) -> None:
    page = help_page(CONFIGS, "eval", [choice])
    told = page.partition(f"Options of {choice}:")[2]
    assert f"  {option}=" in told
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        found = compose("eval", [choice])
    assert all(_has(found, name) for name in re.findall(r"^  ([\w.]+)=", told, re.MULTILINE))


def _has(found: DictConfig, name: str) -> bool:
    """Whether a configuration has a dotted name, whatever its value."""
    *groups, last = name.split(".")
    for group in groups:
        if not isinstance(found, DictConfig) or group not in list(found):
            return False
        found = found._get_node(group)
    return last in list(found)


def test_scripts_print_it() -> None:
    command = [sys.executable, "eval.py", "agent=lgx", "--help"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout == help_page(CONFIGS, "eval", ["agent=lgx", "--help"])
