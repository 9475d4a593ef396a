"""Promises of the README that can be checked automatically."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import COMMANDS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(ROOT.glob("docs/**/*.md")),
    *sorted(ROOT.glob("results/*.md")),
]


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_python_runs_as_printed(code: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) > 5


def test_the_readme_is_short() -> None:
    lines = README.splitlines()
    assert len(lines) <= 100
    assert max(map(len, lines)) <= 120


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_command_exists(page: Path) -> None:
    assert set(re.findall(r"python -m ucon ([a-z][\w-]*)", page.read_text())) <= set(COMMANDS)


def test_every_command_is_told_of() -> None:
    told = (ROOT / "docs" / "commands.md").read_text()
    assert [name for name in COMMANDS if f"python -m ucon {name}" not in told] == []


def test_every_link_leads_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page}: {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_path_exists(page: Path) -> None:
    paths = re.findall(r"`((?:ucon|models|configs|tests|results|checkpoints)/[\w./-]+)`", page.read_text())
    of_example = {"models/agents/mentioned.py", "configs/agent/mentioned.yaml"}
    assert [path for path in paths if not (ROOT / path).exists() and path not in of_example] == []


def test_every_page_is_in_the_menu() -> None:
    menu = re.findall(r"^ +- (?:[^:\n]+: )?(\S+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE)
    pages = {str(page.relative_to(ROOT / "docs")) for page in ROOT.glob("docs/**/*.md")} - {"NEXT.md"}
    assert sorted(menu) == sorted(pages | {f"tables/{page.name}" for page in ROOT.glob("results/*.md")})


def test_every_make_target_exists() -> None:
    makefile = (ROOT / "Makefile").read_text()
    told = "".join(page.read_text() for page in PAGES)
    targets = re.findall(r"(?:^|`)make ([a-z-]+)(?=[` \n])", told, re.MULTILINE)
    assert {"eval", "test", "lint"} <= set(targets)
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_the_notebook_runs_from_top_to_bottom() -> None:
    cells = json.loads((ROOT / "docs" / "first_search.ipynb").read_text())["cells"]
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "find: first_aid_kit" in done.stdout
    assert "found after 64 steps" in done.stdout
    assert not any(cell.get("outputs") for cell in cells), "outputs are not kept"
