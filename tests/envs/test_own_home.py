"""Searches in the user's own homes, from Python."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest

import ucon
from ucon.core.errors import ConfigError, DataError, UconError
from ucon.envs import own_home
from ucon.envs.own_home import EXAMPLE, episodes_of, own_set, say_made
from ucon.habits.types import Placement
from ucon.sim.cache import load_house
from ucon.task.check import check_home
from ucon.task.own_home import building

FLAT = {"rooms": {"kitchen": [3.5, 4], "bedroom": None}}
SAID = "My sister hides her mug in the top cabinet."


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    load_house.cache_clear()
    own_home._made.cache_clear()
    return tmp_path / "cache"


def test_importing_ucon_stays_light() -> None:
    code = "import sys, ucon; print(sorted({'numpy', 'gymnasium', 'torch', 'ucon.envs'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_a_search_in_five_lines() -> None:
    mug = ucon.make_episode(home=FLAT, habits=[SAID], target="mug")
    env = mug.env(habit_level="retrieval")
    _, info = env.reset()
    assert mug.place == Placement("inside", "top_cabinet")
    assert info["target"] == "mug"
    assert SAID in info["habits"][:5]
    assert mug.episode.placed_by[mug.episode.target] == ("mug/own", 0)
    for action in mug.episode.solution:
        _, _, terminated, _, info = env.step(int(action))
    assert terminated
    assert info["is_success"]


def test_a_place_is_taken_as_it_is_said_and_seeds_start_elsewhere() -> None:
    first, again, other = (ucon.make_episode("Rs_int", [SAID], "mug", "on the bed", seed=seed) for seed in (0, 0, 1))
    assert first.place == Placement("ontop", "bed")
    assert first.episode == again.episode
    assert first.episode.start != other.episode.start


def test_what_was_made_is_saved_for_eval(tmp_path: Path) -> None:
    mug = ucon.make_episode(FLAT, [SAID], "mug", "in the fridge")
    episodes, habits = mug.save(tmp_path / "mug")
    assert episodes_of(episodes) == (mug.episode,)
    assert habits.name == "own.habits.xz"


@pytest.mark.parametrize(
    ("given", "part"),
    [
        ({"home": "Rs_imt", "habits": [SAID], "target": "mug"}, "did you mean Rs_int"),
        ({"home": "nowhere.yaml"}, "nowhere.yaml: cannot be read"),
        (
            {"home": {"romes": {}}, "habits": [SAID], "target": "mug"},
            "home.romes: unknown key 'romes': did you mean rooms",
        ),
        (
            {"home": FLAT, "habits": [SAID], "target": "mugg"},
            r"requests\[0\].mugg: unknown object 'mugg': did you mean mug",
        ),
        ({"home": FLAT, "habits": [SAID], "target": "mug", "place": "in the bed"}, "nothing is inside a bed"),
        ({"home": FLAT, "habits": [SAID], "place": "in the bed"}, "give target, too"),
        ({"home": FLAT, "habits": [SAID]}, "nothing to search"),
        ({"home": FLAT, "target": "mug"}, "no sentence of 'habits' is about the mug"),
        ({"home": FLAT, "habits": ["x" * 500], "target": "mug"}, r"habits\[0\]: 500 characters, at most 400"),
        (
            {"home": {"rooms": {"kitchen": {"size": [10**30, 1]}}}, "habits": [SAID], "target": "mug"},
            "at most 15 digits",
        ),
        ({"home": {"rooms": {0: {}}}, "habits": [SAID], "target": "mug"}, "home.rooms: key 0; expected texts"),
        ({"home": "own:my_flat:0123456789ab", "habits": [SAID], "target": "mug"}, "not stored on this machine"),
    ],
)
def test_faults_end_in_a_line(given: dict[str, object], part: str) -> None:
    with pytest.raises(UconError, match=part) as told:
        ucon.make_episode(**given)  # type: ignore[arg-type]
    assert "\n" not in str(told.value)


def test_what_takes_no_such_thing_says_what_does() -> None:
    with pytest.raises(
        DataError, match=r"the bicycle cannot be kept in the microwave \(.*\); it can be kept .* the \w+"
    ):
        ucon.make_episode("Rs_int", ["The bicycle is in the microwave."], "bicycle", "in the microwave")
    with pytest.raises(DataError, match=r"on the piano \(no piano stands in this home\); it can be kept "):
        ucon.make_episode(FLAT, [SAID], "mug", "on the piano")


def test_a_file_is_a_set_that_is_made_once(tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "home.yaml"
    file.write_text(
        EXAMPLE.read_text()
        .replace("  - mug\n", "  - mug\n  - {first aid kit: on the shelf}\n")
        .replace("starts: 1", "starts: 2")
    )
    with pytest.raises(DataError, match=r"home.yaml:\d+: no sentence of 'habits' is about the first aid kit"):
        own_set(file)
    file.write_text(file.read_text().replace("habits:\n", "habits:\n  - The first aid kit is on the shelf.\n"))
    made = own_set(file)
    house = load_house(made.name)
    assert [e.target_category for e in made.episodes] == ["mug", "mug", "first_aid_kit", "first_aid_kit"]
    assert len({e.id for e in made.episodes}) == 4
    for episode in made.episodes:
        check_home(episode, house)
        assert {"mug/own", "first_aid_kit/own"} <= set(episode.entries)
        assert episode.habits_hash == made.dataset.sha256
    own_home._made.cache_clear()
    monkeypatch.setattr(own_home, "build", None)  # the kept set is read, not built
    again = own_set(file)
    assert (again.name, again.episodes, again.dataset.sha256) == (made.name, made.episodes, made.dataset.sha256)
    assert str(tmp_path) not in str([episode.to_json() for episode in made.episodes])
    env = gym.make("UcON-v0", episodes=file, habit_level="gt", observe="symbolic")
    _, info = env.reset(options={"episode": 2})
    assert info["habits"] == ("The first aid kit is on the shelf.",)


def test_another_place_is_another_search(tmp_path: Path) -> None:
    file, ids = tmp_path / "home.yaml", []
    for place in ("in the fridge", "in the top cabinet", "in the fridge"):
        file.write_text(f"home: Rs_int\nhabits: [{SAID}]\nrequests: [mug: {place}]\n")
        ids.append(own_set(file).episodes[0].id)
    assert ids[0] == ids[2] != ids[1]
    assert all(one.startswith("Rs_int/mug/0/") for one in ids)


def test_a_run_warns_of_what_found_no_place_without_searching_for_what_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "home.yaml"
    rooms = "{kitchen: [3.5, 4], bath: {size: [1.75, 1.75], furniture: {bed: 5}}}"
    file.write_text(f"rooms: {rooms}\nhabits: [The mug is in the fridge.]\nrequests: [mug: in the fridge]\n")
    made = own_set(file)
    monkeypatch.setattr(building, "build_program", None)
    say_made(file, made)
    told = capsys.readouterr().err
    assert f"warning: {file}:1: bath: bed: " in told
    assert f"fit; `python -m ucon home check {file}` says what fits instead" in told


def test_a_file_states_no_context() -> None:
    with pytest.raises(ConfigError, match="state no context"):
        episodes_of(EXAMPLE, context=True)
