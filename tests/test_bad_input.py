"""Bad input ends in one clear line: file, place, what was expected, what to do. Never a traceback or a silent run."""

from __future__ import annotations

import json
import lzma
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ucon.configuration.wiring import folder_habits
from ucon.core.errors import DataError, EpisodeError, PlacementError, UconError
from ucon.core.files import write_manifest
from ucon.core.rng import stream
from ucon.envs.knowledge import HabitSource
from ucon.envs.ucon_env import UcONEnv
from ucon.habits import book
from ucon.habits.book import ANCHORS, BOOK_FOLDER, read_book
from ucon.language.store import VectorTable
from ucon.sim.arrangement import Arrangement
from ucon.sim.cache import load_house
from ucon.sim.placement import place
from ucon.task.episode import Episode
from ucon.task.making.sampler import EpisodeSampler
from ucon.task.sets import load_episodes

ROOT = Path(__file__).parents[1]
FIRST = load_episodes("mini")[11]


def changed(path: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """A file of two episodes, the second changed."""
    data = FIRST.to_json()
    other = json.loads(json.dumps(data))
    change(other)
    path.write_bytes(lzma.compress(f"{json.dumps(data)}\n{json.dumps(other)}\n".encode()))
    return path


def target(data: dict[str, Any]) -> list[Any]:
    row: list[Any] = data["arrangement"]["objects"][data["target"]]
    return row


def put(container: Callable[[dict[str, Any]], Any], key: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda data: container(data).__setitem__(key, value)


def whole(data: dict[str, Any]) -> dict[str, Any]:
    return data


IN_THE_FILE = {
    "category": (put(target, 0, "coffee_cupp"), "did you mean coffee_cup"),
    "position": (put(target, 1, ["a", 0, 0]), "expected x, y, z in metres"),
    "nowhere": (put(target, 1, [float("nan"), 0, 0]), "NaN, expected finite numbers"),
    "quaternion": (put(target, 2, [0, 0, 0, 2]), "expected a unit quaternion"),
    "relation": (put(target, 4, "above"), "expected one of"),
    "anchor": (put(target, 5, "table"), "expected a whole number"),
    "task": (put(whole, "task", "papr"), "did you mean paper"),
    "heading": (put(whole, "start", [1, 1, 7]), "start heading 7, expected 0 to 3"),
    "length": (put(whole, "shortest_path_m", "far"), "expected metres above 0"),
    "already there": (put(whole, "shortest_path_m", 0.0), "expected metres above 0"),
    "solution": (put(whole, "solution", "0178"), "expected digits 0 to 6"),
    "target": (put(whole, "target", 99), "target 99, expected an index below"),
    "no knowledge": (put(whole, "entries", []), "expected at least one entry"),
    "second target": (
        lambda data: data["arrangement"]["objects"].append(target(data)) or data["placed_by"].append(["", -1]),
        "expected 1, since it is to be found",
    ),
}

IN_THE_HOME = {
    "scene": (put(whole, "scene", "Rs_imt"), "did you mean Rs_int"),
    "other home": (put(whole, "scene", "Ihlen_0_int"), "make the episodes again"),
    "start": (put(whole, "start", [9999, 0, 0]), r"node \(9999, 0\), expected below"),
    "start in a wall": (put(whole, "start", [0, 0, 0]), "expected a free node of Rs_int"),
    "anchor": (put(target, 5, 99999), "anchor of object .* 99999, expected an instance below"),
    "holder": (put(target, 7, 99999), "holder of object .* 99999, expected an instance below"),
    "compartment": (lambda data: target(data).__setitem__(slice(7, 9), [0, 99]), "compartment of object"),
    "onto itself": (
        lambda data: put(target, 5, load_house("Rs_int").n_instances + data["target"])(data),
        "expected another instance than itself",
    ),
    "blocked": (put(lambda d: d["arrangement"], "blocked", [[999, 999]]), "expected below"),
    "removed": (put(lambda d: d["arrangement"], "removed", [99999]), "removes instance 99999"),
    "entry": (put(whole, "entries", ["nothing/3"]), "unknown entry 'nothing/3'"),
    "habits": (put(whole, "habits_hash", "0" * 64), "choose those habits"),
}


@pytest.mark.parametrize("name", IN_THE_FILE)
def test_wrong_episode_data_name_file_and_line(name: str, tmp_path: Path) -> None:
    change, message = IN_THE_FILE[name]
    path = changed(tmp_path / "mine.jsonl.xz", change)
    with pytest.raises(EpisodeError, match=message) as caught:
        load_episodes(path)
    assert re.match(rf"{re.escape(str(path.resolve()))}:2: ", str(caught.value))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", IN_THE_HOME)
def test_episodes_that_do_not_fit_their_home_are_refused(name: str, tmp_path: Path) -> None:
    change, message = IN_THE_HOME[name]
    episode = load_episodes(changed(tmp_path / "mine.jsonl.xz", change))[1]
    with pytest.raises(UconError, match=message) as caught:
        UcONEnv([episode], observe="symbolic").reset(seed=0)
    assert "\n" not in str(caught.value)


def test_a_shipped_habit_file_notices_a_flipped_bit(tmp_path: Path) -> None:
    names = sorted(path.name for path in BOOK_FOLDER.glob("*.txt") if path.name != ANCHORS)[:3]
    for name in names:
        (tmp_path / name).write_bytes((BOOK_FOLDER / name).read_bytes())
    write_manifest(tmp_path, names)
    assert read_book(tmp_path, verified=True).entries
    data = bytearray((tmp_path / names[1]).read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / names[1]).write_bytes(bytes(data))
    with pytest.raises(DataError, match=f"{names[1]}.*truncated or altered, restore"):
        read_book(tmp_path, verified=True)


HABITS = (
    """# {category} | two people
@ ontop {anchor}
@ nextto bed
@ inside bottom_cabinet
"""
    + "1: They keep it where the morning light falls first.\n" * 8
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HABITS.format(category="coffee_cupp", anchor="shelf"), r"mine\.txt:1: unknown category.*coffee_cup"),
        (HABITS.format(category="coffee_cup", anchor="moon_rock"), r"mine\.txt:2: unknown anchor"),
        (HABITS.format(category="bed", anchor="shelf"), r"mine\.txt:3: a bed placed onto itself"),
        (HABITS.format(category="coffee_cup", anchor="shelf")[:-20], r"mine\.txt:12: .*cut off"),
        ("", r"mine\.txt:1: empty"),
    ],
)
def test_wrong_habit_files_name_file_and_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text(text)
    with pytest.raises(DataError, match=message):
        folder_habits(str(tmp_path))


def test_own_anchors_must_exist(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text(HABITS.format(category="coffee_cup", anchor="moon_rock"))
    (tmp_path / "anchors.txt").write_text("A bed: nextto\nA moon_rock: ontop\nA bottom_cabinet: inside\n")
    with pytest.raises(DataError, match=r"anchors\.txt:2: unknown category 'moon_rock'"):
        folder_habits(str(tmp_path))


@pytest.mark.parametrize("suffix", [".npy", ".keys"])
@pytest.mark.parametrize("damage", ["cut", "flip", "gone"])
def test_damaged_embeddings_are_refused(suffix: str, damage: str, tmp_path: Path) -> None:
    stem = tmp_path / "table"
    VectorTable.save(stem, ["a", "b", "c"], np.eye(3, dtype=np.float16))
    write_manifest(tmp_path, ["table.npy", "table.keys"])
    assert len(VectorTable.load(stem)) == 3
    path = stem.with_suffix(suffix)
    data = bytearray(path.read_bytes())
    data[-3] ^= 1
    if damage == "gone":
        path.unlink()
    else:
        path.write_bytes(data[:-5] if damage == "cut" else data)
    with pytest.raises(DataError, match=f"table{suffix}: (no such file|.*truncated or altered, restore)"):
        VectorTable.load(stem)


def test_targets_that_cannot_exist_are_refused() -> None:
    sampler = EpisodeSampler(book())
    with pytest.raises(EpisodeError, match="Rs_int: no wanted category of dataset 'book' can be placed there"):
        sampler.sample("Rs_int", 0, targets=["unicorn"])


def test_nothing_is_placed_onto_itself() -> None:
    house = load_house("Rs_int")
    tables = [k for k, name in enumerate(house.categories) if name == "breakfast_table"]
    with pytest.raises(PlacementError):
        place(house, Arrangement(removed=(tables[0],)), "breakfast_table", "ontop", tables[0], stream(0, "itself"))


def test_an_empty_knowledge_base_is_refused() -> None:
    with pytest.raises(UconError, match="empty knowledge base"):
        HabitSource().knowledge(replace(FIRST, entries=()), "full")


def command(*words: str) -> str:
    """Run a command that must end with exit code 2, and return its one line of error."""
    done = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True, timeout=120)
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 2, done.stderr
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("error: ")
    return lines[0]


def evaluation(out: Path, *overrides: str) -> tuple[str, ...]:
    return ("eval.py", "agent=random", "limit=2", "pictures=0", "progress=false", f"out={out}/run", *overrides)


@pytest.mark.parametrize("workers", [0, 1])
def test_eval_ends_in_one_line_also_from_a_worker(workers: int, tmp_path: Path) -> None:
    path = changed(tmp_path / "mine.jsonl.xz", IN_THE_HOME["scene"][0])
    line = command(*evaluation(tmp_path, f"episodes={path}", f"workers={workers}"))
    assert "unknown scene 'Rs_imt': did you mean Rs_int?" in line


def test_eval_refuses_a_cut_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.jsonl.xz"
    path.write_bytes(changed(path, lambda data: None).read_bytes()[:-50])
    assert "mine.jsonl.xz: not a whole file of episodes" in command(*evaluation(tmp_path, f"episodes={path}"))


def test_eval_refuses_a_wrong_habit_file(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text(HABITS.format(category="coffee_cupp", anchor="shelf"))
    line = command(*evaluation(tmp_path, "habits=folder", f"habits.path={tmp_path}"))
    assert "mine.txt:1: unknown category 'coffee_cupp'" in line


def test_making_episodes_refuses_a_wrong_habit_file(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text(HABITS.format(category="bed", anchor="shelf"))
    words = ("episodes", "make", "mini", "--limit", "1", "--habits", str(tmp_path), "--out", f"{tmp_path}/x.jsonl.xz")
    assert "a bed placed onto itself" in command("-m", "ucon", *words)


def test_a_good_file_of_ones_own_is_played(tmp_path: Path) -> None:
    """The changes above are refused because they are wrong, not because the file is the user's own."""
    path = changed(tmp_path / "mine.jsonl.xz", lambda data: data.update(id="mine"))
    episodes = load_episodes(path)
    assert [e.id for e in episodes] == [FIRST.id, "mine"]
    assert isinstance(episodes[1], Episode)
    UcONEnv(episodes, observe="symbolic").reset(options={"episode": 1})
