"""``python -m ucon pack``: what it writes is enough to play and to train without PyBullet."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.core.files import MANIFEST
from ucon.sim.cache import PACKED, file_name, load_house
from ucon.task.sets import episode_sets, load_episodes, save_episodes

ROOT = Path(__file__).parents[2]
PLAY = """
import sys
from ucon.envs.ucon_env import UcONEnv
from ucon.core.errors import UconError
try:
    env = UcONEnv(sys.argv[1], observe="symbolic", detector=True, habit_level="gt")
    env.reset(options={"episode": int(sys.argv[2])})
    for action in env.episode.solution:
        *_, info = env.step(int(action))
    print(env.episode.scene, info["episode_metrics"]["success"])
except UconError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def pack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pack of two training episodes in one home that is not shipped, with that home and Rs_int."""
    folder = tmp_path_factory.mktemp("pack")
    chosen = load_episodes("train")[0]
    assert not (PACKED / file_name(chosen.scene)).exists()
    save_episodes([e for e in load_episodes("train") if e.scene == chosen.scene][:2], folder / "few.jsonl.xz")
    out = folder / "out"
    assert main(["pack", "--episodes", str(folder / "few.jsonl.xz"), "Rs_int", "--out", str(out)]) == 0
    return out


def there(pack: Path, empty: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Python on a machine that has the clone and the pack, an empty cache of homes and no PyBullet."""
    (empty / "pybullet.py").write_text("raise ImportError('not here')")
    changed = {"UCON_PACK": str(pack), "UCON_CACHE": str(empty / "cache"), "PYTHONPATH": f"{empty}{os.pathsep}{ROOT}"}
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=ROOT, env=os.environ | changed, capture_output=True, text=True, timeout=300)


def test_sets_and_homes_are_written_with_their_manifests(pack: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = load_episodes(pack / "episodes" / "few.jsonl.xz")[0].scene
    assert {p.name for p in (pack / "homes").iterdir()} == {file_name(scene), file_name("Rs_int"), MANIFEST}
    assert {p.name for p in (pack / "episodes").iterdir()} == {"few.jsonl.xz", MANIFEST}
    assert main(["pack", "mini", "--out", str(pack.parent / "mini")]) == 0
    assert {p.name for p in (pack.parent / "mini" / "episodes").iterdir()} == {
        MANIFEST,
        *(path.name for name, path in episode_sets().items() if name.split(".")[0] == "mini"),
    }
    assert f"UCON_PACK={pack.parent / 'mini'}" in capsys.readouterr().out


def test_a_packed_set_is_played_without_bullet_by_its_name(pack: Path, tmp_path: Path) -> None:
    done = there(pack, tmp_path, "-c", PLAY, "few", "1")
    scene = load_episodes(pack / "episodes" / "few.jsonl.xz")[1].scene
    assert done.stdout.strip() == f"{scene} True", done.stderr[-2000:]


@pytest.mark.slow
def test_a_packed_set_is_learned_from_without_bullet(pack: Path, tmp_path: Path) -> None:
    validation = ("episodes=few", "n_play=0", "n_demonstrations=1", "choose=loss")
    options = ("episodes=few", "levels=[gt]", "batch=1", "device=cpu", *(f"validation.{o}" for o in validation))
    few = [
        *(f"learner.{option}" for option in options),
        "training.steps=1",
        "training.validate_every=1",
        "env.max_habits=900",
    ]
    run = ["train.py", "agent=habit_policy_e2e", "learner=imitation", "progress=false", f"out={tmp_path / 'run'}"]
    done = there(pack, tmp_path, *run, *few)
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / "run" / "model" / "policy.safetensors").is_file()
    assert json.loads((tmp_path / "run" / "model" / "config.json").read_text())["max_habits"] == 900


def test_a_home_that_was_not_packed_is_one_clear_line(pack: Path, tmp_path: Path) -> None:
    known = load_episodes(pack / "episodes" / "few.jsonl.xz")[0].scene
    number = next(k for k, episode in enumerate(load_episodes("train")) if episode.scene != known)
    missing = load_episodes("train")[number].scene
    said = there(pack, tmp_path, "-c", PLAY, "train", str(number)).stdout.strip()
    assert said.startswith(f"home '{missing}': not in the package, {pack} and the cache, and PyBullet")
    assert "run `python -m ucon pack SET_OR_HOME --out FOLDER`" in said
    assert len(said.splitlines()) == 1
    unknown = there(pack, tmp_path, "-c", "from ucon.sim.cache import load_house; load_house('Rs_imt')").stderr
    assert "Rs_imt" in unknown.splitlines()[-1]
    assert "PyBullet" not in unknown.splitlines()[-1]


def test_a_folder_that_is_none_is_told(pack: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_PACK", str(tmp_path / "none"))
    with pytest.raises(ConfigError, match=r"UCON_PACK=.*none: no such folder; name what `python -m ucon pack"):
        episode_sets()
    load_house.cache_clear()
    with pytest.raises(ConfigError, match="UCON_PACK"):
        load_house(load_episodes(pack / "episodes" / "few.jsonl.xz")[0].scene)
