"""Every command on a page is accepted by the program: options, groups, files of configs/, targets of make.

Lines of ``bash`` and ``console`` blocks are read, and commands in the text that have arguments. Names in capitals (RUN,
FOLDER, PATH) stand for the reader's own.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hydra import compose, initialize_config_dir
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.utils import get_object
from omegaconf import OmegaConf

from ucon.__main__ import COMMANDS, _module, main
from ucon.configuration.arguments import check_arguments
from ucon.configuration.known_options import EVALUATION, check_options
from ucon.core.errors import ConfigError
from ucon.lives.making.plans import LIFE_SETS
from ucon.programs.training import chosen_run
from ucon.task.own_home.shipped import CASES, HOMES

ROOT = Path(__file__).parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *sorted(ROOT.glob("docs/**/*.md")),
    *sorted(ROOT.glob("results/*.md")),
]
_BLOCK = re.compile(r"^ *```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
_WITHIN_TEXT = re.compile(r"`(python (?:eval\.py|train\.py|-m ucon \w[\w-]*) [^`]+)`")
#: A placeholder for any value of a group: ``agent=NAME``.
_ANY = re.compile(r"\w+=[A-Z]+")
#: From docs/EXTENDING.md, which has its own test.
_OF_AN_EXAMPLE = "agent=mentioned"
SHELLS = ("bash", "console")
SETS = {
    path.name.partition(".")[0] for folder in ("episodes", "ucon/task/data") for path in (ROOT / folder).glob("*.xz")
}


def commands_of(text: str) -> Iterator[list[str]]:
    """The words of each command on a page, without comments and without ``NAME=VALUE`` before the program."""
    lines = [line for kind, block in _BLOCK.findall(text) if kind in SHELLS for line in block.splitlines()]
    for line in [*lines, *_WITHIN_TEXT.findall(_BLOCK.sub("", text))]:
        words = shlex.split(line, comments=True)
        words = list(itertools.dropwhile(lambda word: re.match(r"[A-Z_]+=", word), words))
        if words:
            any_group = [word for word in words if _ANY.fullmatch(word) and is_group(word.partition("=")[0])]
            yield [word for word in words if word not in (*any_group, "--help")]


def is_group(name: str) -> bool:
    """Whether an option chooses a file from a folder of ``configs/``."""
    return (ROOT / "configs" / name).is_dir()


def told() -> list[tuple[str, list[str]]]:
    """Every distinct command, with the first page that has it."""
    found: dict[tuple[str, ...], str] = {}
    for page in PAGES:
        for words in commands_of(page.read_text()):
            found.setdefault(tuple(words), str(page.relative_to(ROOT)))
    return [(page, list(words)) for words, page in found.items()]


TOLD = told()


def starting(*start: str) -> list[Any]:
    """The commands that start with these words, without them."""
    return [
        pytest.param(words[len(start) :], id=f"{page}: {shlex.join(words)[:90]}")
        for page, words in TOLD
        if tuple(words[: len(start)]) == start
    ]


def test_pages_have_commands() -> None:
    """There are commands of every kind, so that no test below is empty by mistake."""
    assert len(starting("python", "eval.py")) > 30
    assert len(starting("python", "train.py")) > 10
    assert len(starting("python", "-m", "ucon")) > 20
    assert len([words for _, words in TOLD if words[0] == "make"]) > 5


def test_every_program_on_a_page_is_known() -> None:
    programs = {words[0] for _, words in TOLD}
    assert programs <= {"python", "make", "source", "pip", "ray"}, programs
    for page, words in TOLD:
        if words[0] == "python" and words[1] not in ("eval.py", "train.py"):
            assert words[1] == "-m", (page, words)
            assert importlib.util.find_spec(words[2]) is not None, f"{page}: {words[2]}"


def first_of(words: list[str]) -> list[str]:
    """Overrides of a sweep's first run; checks that the other runs' files exist and their values have the same type."""
    if "-m" not in words:
        return words
    first = []
    for one in OverridesParser.create().parse_overrides([word for word in words if word != "-m"]):
        if not one.is_sweep_override():
            first.append(one.input_line)
            continue
        name, values = one.key_or_group, list(one.sweep_string_iterator())
        if is_group(name):
            there = {path.stem for path in (ROOT / "configs" / name).glob("*.yaml")}
            assert set(values) <= there | {_OF_AN_EXAMPLE.partition("=")[2]}, name
        assert len({type(yaml.safe_load(value)) for value in values}) == 1, name
        first.append(f"{name}={values[0]}")
    return first


def check_evaluation(words: list[str]) -> None:
    """Check options as ``eval.py`` does, except for the reader's own files."""
    known = [word for word in first_of(words) if word != _OF_AN_EXAMPLE]
    with initialize_config_dir(str(ROOT / "configs"), version_base="1.3"):
        config: Any = OmegaConf.to_container(compose("eval", [*known, "out=runs/x"]), resolve=True)
    check_options(config, EVALUATION)
    for part in (config["env"], config["agent"]):
        get_object(part["_target_"])
        check_arguments(part)
    assert config["episodes"] in {*SETS, *LIFE_SETS, *HOMES, *CASES} or config["episodes"].endswith(
        (".jsonl.xz", ".yaml")
    )


@pytest.mark.parametrize("words", starting("python", "eval.py"))
def test_evaluations_are_composed(words: list[str]) -> None:
    check_evaluation(words)


@pytest.mark.parametrize("words", starting("python", "train.py"))
def test_trainings_are_composed(words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Checked as ``train.py`` does; the only possible fault is that the run named by ``resume=`` does not exist."""
    monkeypatch.chdir(tmp_path)
    overrides = first_of([word for word in words if not word.startswith("hydra/launcher=")])
    with initialize_config_dir(str(ROOT / "configs"), version_base="1.3"):
        config = compose("train", overrides)
    if config.resume:
        with pytest.raises(ConfigError, match="no run there"):
            chosen_run(config, overrides, None)
        return
    check_arguments(chosen_run(config, overrides, tmp_path).config["learner"])


@pytest.mark.parametrize("words", starting("python", "-m", "ucon"))
def test_commands_take_their_options(words: list[str]) -> None:
    name, rest = words[0], words[1:]
    assert name in COMMANDS
    parser = argparse.ArgumentParser(prog=f"ucon {name}")
    _module(name).add_arguments(parser)
    parser.parse_args(rest)


@pytest.mark.parametrize("words", starting("python", "-m", "ucon", "verify"))
def test_runs_that_pages_verify_are_right(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    runs = [word for word in words if word.startswith("results/")]
    assert main(["verify", *(runs or ["results/learned-frontier"])]) == 0
    assert "the checksums are right" in capsys.readouterr().out


def test_targets_of_make_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    asked = {word for _, words in TOLD if words[0] == "make" for word in words[1:] if "=" not in word}
    assert {"eval", "test", "lint"} <= asked <= targets, asked - targets


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_tells_its_options(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert f"usage: ucon {name}" in capsys.readouterr().out


@pytest.mark.parametrize("script", ["eval.py", "train.py"])
def test_scripts_tell_their_options(script: str) -> None:
    done = subprocess.run([sys.executable, script, "--help"], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "Options (name=value):" in done.stdout


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("python eval.py agent=belif", "belif"),
        ("python eval.py -m agent=belief,lgxx habit_level=none", "lgxx"),
        ("python eval.py limit=many  # of them", "limit"),
        ("python eval.py agent=lgx agent.heat=0", "heat"),
        ("python eval.py agent=frontier episodes=tset", "assert"),
    ],
)
def test_what_is_wrong_is_found(line: str, wrong: str) -> None:
    ((_, script, *options),) = commands_of(f"```bash\n{line}\n```")
    assert script == "eval.py"
    with pytest.raises(Exception, match=wrong):
        check_evaluation(options)
