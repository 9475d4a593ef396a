"""A stored configuration builds what ``configs/`` builds at that place, and starts or contacts nothing on its own."""

from __future__ import annotations

import copy
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from omegaconf import OmegaConf

from tests.commands.stored import CONFIGS, composed, each, stored
from tests.commands.test_cli import run
from tests.evaluation.records import reseal
from tests.test_bad_input import command
from ucon.configuration.constructors import places
from ucon.configuration.old_names import in_todays_names
from ucon.configuration.stored import checked, has_to_be_said
from ucon.core.errors import DataError, UconError
from ucon.evaluation.kept.finished import read_config
from ucon.programs.training import chosen_run

ROOT = Path(__file__).parents[2]
BUILT = ("agent", "env", "learner")
YOLO = {"detector.python": "/opt/yolo/bin/python", "detector.weights": "/opt/yolo/w.pt"}
SERVER = {"language.client.base_url": "http://127.0.0.1:8000/v1"}


def refused(config: dict[str, Any], said: dict[str, Any] | None = None) -> str:
    with pytest.raises(UconError) as caught:
        checked(config, "RUN/config.yaml", BUILT, said or {}, "--set ")
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("RUN/config.yaml: ")
    return str(caught.value)


def test_whatever_configs_describe_may_be_stored() -> None:
    said = {
        "detector/yolo_world": YOLO,
        "experiment/table1_lgx_llama8b_yoloworld": YOLO,
        "experiment/table1_lgx_gpt4_gt": {**SERVER, "language.client.api_key_env": "KEY"},
    }
    for name, config in stored().items():
        out = checked(config, name, BUILT, said.get(name, {}), "--set ")
        assert out.keys() == config.keys()
        assert name in said or out == config


def test_every_recorded_run_may_be_built() -> None:
    recorded = [*ROOT.glob("results/*/config.yaml"), *ROOT.glob("checkpoints/*/config.yaml")]
    assert len(recorded) > 50
    for path in recorded:
        config = yaml.load(path.read_text(), yaml.CSafeLoader)
        assert checked(config, str(path), BUILT, {}, "--set ") == in_todays_names(config, str(path))


def test_a_new_file_is_permitted_without_being_listed(tmp_path: Path) -> None:
    shutil.copytree(CONFIGS, tmp_path / "configs")
    (tmp_path / "configs" / "detector" / "mine.yaml").write_text("# Mine.\n_target_: mine.Detector\n")
    found = places(tmp_path / "configs")
    names = found.within(found.within(found.within(found.within({()}, "learner"), "env"), "config"), "detector")
    assert "mine.Detector" in {call.target for call in found.permitted(names)}
    assert "mine.Detector" not in {call.target for call in found.permitted({("agent",)})}


LINK = {"_target_": "ucon.perception.detectors.worker_link.WorkerLink", "command": ["/bin/sh"], "what": "x"}


def put(config: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    *groups, name = key.split(".")
    node = config
    for group in groups:
        node = node[int(group)] if isinstance(node, list) else node[group]
    node[int(name) if isinstance(node, list) else name] = value
    return config


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("agent", LINK, "agent._target_=ucon.perception.detectors.worker_link.WorkerLink: nothing in configs/ builds"),
        ("env.detector", LINK, "env.detector._target_=ucon.perception"),
        ("learner.policy", LINK, "learner.policy._target_="),
        ("learner.policy.backbone", LINK, "learner.policy.backbone._target_="),
        ("learner.env", LINK, "learner.env._target_="),
        ("learner.env.config.detector", LINK, "learner.env.config.detector._target_="),
        ("learner.env.config.source.dataset", LINK, "learner.env.config.source.dataset._target_="),
        ("learner.loss.weights", LINK, "learner.loss.weights._target_="),
        ("learner.levels", [LINK], "learner.levels.0._target_="),
        ("learner.seed", {"deep": [{"er": LINK}]}, "learner.seed.deep.0.er._target_="),
        ("learner.validation._target_", "ucon.habits.book", "learner.validation._target_=ucon.habits.book"),
        ("learner.validation._target_", ["os.system"], "learner.validation._target_="),
        ("learner.validation._target_", None, "learner.validation._target_=None"),
        ("learner.validation._partial_", True, "learner.validation is called with _partial_: True, which configs/"),
        ("learner.validation._args_", ["x"], "learner.validation is called with _args_"),
        ("learner.validation._convert_", "object", "learner.validation is called with _convert_"),
        ("learner.env._recursive_", True, "learner.env is called with _recursive_: True"),
        ("learner.env._recursive_", 0, "learner.env is called with _recursive_: 0"),
        ("learner.loss.weights", {"_args_": [1]}, "learner.loss.weights._target_=None: nothing in configs/"),
        ("learner.env.extra", {"detector": LINK}, "learner.env.extra.detector._target_="),
        ("learner.initial", "${oc.env:HOME}", "a stored run has no interpolations"),
        ("learner.initial", "x${oc.env:HOME}", "a stored run has no interpolations"),
    ],
)
def test_what_configs_build_elsewhere_or_otherwise_is_refused(key: str, value: Any, told: str) -> None:
    config = copy.deepcopy(stored()["learner/imitation"])
    assert told in refused(put(config, key, value))


def test_programs_and_servers_are_said_again() -> None:
    told = refused(stored()["detector/yolo_world"])
    assert "--set detector.python=yolo-world/bin/python --set detector.weights=yolov8l-worldv2.pt" in told
    asking = composed("eval", "agent=lgx", "language=chat_api", "language.client.api_key_env=KEY")
    told = refused(asking)
    assert "--set language.client.api_key_env=KEY --set language.client.base_url=http://127.0.0.1:8000/v1" in told
    key = {"language.client.api_key_env": "OTHER"}
    assert "api_key_env" not in refused(asking, key)
    allowed = checked(asking, "", BUILT, {**SERVER, **key}, "")
    assert allowed["agent"]["language"]["client"]["api_key_env"] == "OTHER"
    assert allowed["language"] == asking["language"], "it is not built"


def test_what_is_said_reaches_every_place_that_is_built() -> None:
    config = composed("train", "agent=vtn", "learner=dagger", "detector=yolo_world")
    assert "--set detector.python=" in refused(config)
    allowed = checked(config, "", BUILT, YOLO, "")
    for env in (allowed["env"], allowed["learner"]["env"]["config"]):
        assert env["detector"]["python"] == YOLO["detector.python"]


def test_downloads_are_said_again_and_files_are_not() -> None:
    off = composed("eval", "agent=lgx", "language=causal_lm")
    assert checked(off, "", BUILT, {}, "") == off
    on = composed("eval", "agent=lgx", "language=causal_lm", "language.download=true")
    assert "give --set language.download=True" in refused(on)
    assert checked(on, "", BUILT, {"language.download": True}, "")["agent"]["language"]["download"] is True
    assert "--set detector.weights.download=True" in refused(
        composed("eval", "detector=owlv2", "detector.weights.download=true")
    )


@pytest.mark.parametrize("option", ["detector.python", "language.client.base_url", "language.download"])
def test_options_that_are_said(option: str) -> None:
    assert has_to_be_said(option)


@pytest.mark.parametrize("option", ["agent.seed", "detector", "x", "", "env.detector.python", "detector._target_"])
def test_options_that_are_not(option: str) -> None:
    assert not has_to_be_said(option)


@pytest.fixture
def canary(tmp_path: Path) -> tuple[Path, Path]:
    """A program that leaves a file, and that file."""
    program, left = tmp_path / "python", tmp_path / "canary"
    program.write_text(f"#!/bin/sh\ntouch {left}\n")
    program.chmod(0o755)
    return program, left


def a_run(folder: Path, key: str, value: Any) -> Path:
    shutil.copytree(ROOT / "results" / "learned-frontier", folder)
    config = yaml.safe_load((folder / "config.yaml").read_text())
    (folder / "config.yaml").write_text(yaml.safe_dump(put(config | {"limit": 1}, key, value)))
    reseal(folder)  # checksums are not signatures: anybody can write them
    return folder


def test_a_strangers_folder_starts_no_program(tmp_path: Path, canary: tuple[Path, Path]) -> None:
    """Three ways that once did: a link to a program, a detector with one, and the same inside a factory."""
    program, left = canary
    link = {**LINK, "command": [str(program)]}
    yolo = each()["ucon.perception.detectors.yolo_world.YoloWorldDetector"][1]
    yolo = yolo | {"python": str(program), "weights": str(program)}
    runs = [
        a_run(tmp_path / "link", "env.detector", link),
        a_run(tmp_path / "agent", "agent", link),
        a_run(tmp_path / "yolo", "env.detector", yolo),
        a_run(tmp_path / "dataset", "env.source.dataset", link),
    ]
    result = run("replay", *map(str, runs), "--workers", "0", "--every", "500", "--out", str(tmp_path / "out"))
    told = result.stderr.split(": not played: ")[1:]
    assert (result.returncode, result.stdout, len(told)) == (1, "", 4)
    assert f"give --set detector.python={program} --set detector.weights={program}" in told[2]
    listed = run("cases", str(runs[3]), "--out", str(tmp_path / "cases"))
    assert listed.returncode == 2
    assert "env.source.dataset._target_=" in listed.stderr
    for name, detector in (("a", link), ("b", yolo)):
        folder = tmp_path / name
        folder.mkdir()
        config = put(copy.deepcopy(stored()["learner/imitation"]), "learner.env.config.detector", detector)
        (folder / "config.yaml").write_text(yaml.safe_dump(config))
        line = command("train.py", f"resume={folder}", "progress=false")
        assert ("learner.env.config.detector._target_=" in line) == (name == "a")
        assert (f"give ++detector.python={program}" in line) == (name == "b")
    assert not left.exists()


def hostile_builds(folder: Path, parts: dict[str, Any], how: str) -> dict[str, Any]:
    """The output of :mod:`tests.commands.hostile`; ``folder`` has a program and code that would leave a file."""
    left = folder / "canary"
    (folder / "program").write_text(f"#!/bin/sh\ntouch {left}\n")
    (folder / "program").chmod(0o755)
    (folder / "mine.py").write_text(f"open({str(left)!r}, 'w')\ndef evil(*a, **k): open({str(left)!r}, 'w')\n")
    words = [sys.executable, "-m", "tests.commands.hostile", str(folder), how]
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{folder}"}
    done = subprocess.run(
        words, input=json.dumps(parts), cwd=ROOT, env=environment, capture_output=True, text=True, timeout=1800
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    assert found["seen"] == []
    assert not left.exists()
    return found


def test_hostile_arguments_start_nothing(tmp_path: Path) -> None:
    parts = {target: part for target, part in each().items() if not target.endswith("Learner")}
    found = hostile_builds(tmp_path, parts, "fast")
    assert found["tried"] > 250
    assert found["built"] > 60, "what is let through is tried"


@pytest.mark.slow
def test_all_hostile_arguments_start_nothing(tmp_path: Path) -> None:
    found = hostile_builds(tmp_path, each(), "all")
    assert found["tried"] > 2300
    assert found["built"] > 500


def test_the_watch_sees_what_it_should(tmp_path: Path) -> None:
    """A test of the test: programs, sockets and code from the folder are noticed."""
    code = (
        "import subprocess, socket, sys; from pathlib import Path; from tests.commands.hostile import Watch\n"
        f"watch = Watch(Path({str(tmp_path)!r})); watch.armed = True\n"
        "subprocess.run(['true']); socket.socket().close(); import mine; watch.armed = False\n"
        "print(sorted({event for _, event, _ in watch.seen}))"
    )
    (tmp_path / "mine.py").write_text("x = 1\n")
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{tmp_path}"}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.stdout.strip() == "['exec', 'socket.__new__', 'subprocess.Popen']", done.stderr


def bomb() -> str:
    """Ten lines that describe ten thousand million nodes."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 10)]
    return "\n".join(lines)


@pytest.mark.parametrize("text", [bomb(), "[" * 3000, "x: y\n" * 300_000, "env: {}\n" + "{a: " * 500], ids=len)
def test_configurations_that_would_not_end(text: str, tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text(text)
    with pytest.raises(DataError, match=r"config\.yaml"):
        read_config(tmp_path)
    with pytest.raises(DataError, match=r"config\.yaml"):
        chosen_run(OmegaConf.create({"resume": str(tmp_path)}), [], None)
