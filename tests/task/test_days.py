"""Homes with only their owner's habits: places with sides and rooms, several places, things, days."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.envs import own_home
from ucon.envs.own_home import OwnSet, own_set
from ucon.habits.types import Placement
from ucon.sim.cache import load_house
from ucon.sim.placement.spot import Side
from ucon.sim.state import SceneState
from ucon.task.check import check_home
from ucon.task.own_home.places import said_place, spoken
from ucon.task.own_home.reading import read_home
from ucon.task.own_home.wish import Place

ROOMS = ["kitchen", "Anna's study"]
HOME = """
rooms:
  bedroom: {size: [4, 4], furniture: {bed: 1, desk: 1, shelf: 1, armchair: 1}}
  kitchen: {size: [3, 3.5], furniture: {fridge: 1, countertop: 1, sink: 1, shelf: 1}}
habits:
  - The book lies at the foot of the bed, where I drop it.
  - Mugs dry on the counter, but mine is taken along to the desk.
  - Cereal bowls are kept in the kitchen shelf.
  - I work on the laptop till noon.
  - It rains a lot here.
requests:
  - paperback: at the foot of the bed
  - mug: [on the countertop, on the desk]
  - bowl: in the shelf in the kitchen
things:
  - laptop: on the desk, facing its front
others: none
starts: 2
"""


def read(text: str, folder: Path) -> Any:
    file = folder / "x.yaml"
    file.write_text(text)
    return read_home(file)


@pytest.mark.parametrize(
    ("words", "relation", "anchor", "side", "room", "again"),
    [
        ("at the foot of the bed", "ontop", "bed", "front", None, "at the foot of the bed"),
        ("on the head end of my bed", "ontop", "bed", "behind", None, "at the head of the bed"),
        ("behind the laptop", "nextto", "laptop", "behind", None, "behind the laptop"),
        ("to the left of the laptop", "nextto", "laptop", "left", None, "left of the laptop"),
        ("in front of the sofa in the kitchen", "nextto", "sofa", "front", "kitchen", None),
        ("on the right side of the couch", "ontop", "sofa", "right", None, "on the right of the sofa"),
        ("in the shelf in anna's study", "inside", "shelf", None, "Anna's study", None),
        ("in the shelf", "inside", "shelf", None, None, "in the shelf"),
        ("beside the bed", "nextto", "bed", None, None, "beside the bed"),
    ],
)  # fmt: skip
def test_places_in_english(
    words: str, relation: Any, anchor: str, side: Side | None, room: str | None, again: str | None
) -> None:
    place = said_place(words, ROOMS)
    assert place == Place(Placement(relation, anchor), side, room=room)
    assert again is None or spoken(place) == again
    assert said_place(spoken(place), ROOMS) == place


def test_a_thing_may_face_the_front_of_what_it_stands_on() -> None:
    place = said_place("on the desk, facing its front", ROOMS)
    assert place == Place(Placement("ontop", "desk"), facing=True)
    assert "only a thing on top of another" in str(said_place("beside the desk, facing its front", ROOMS))


@pytest.mark.parametrize(
    ("old", "new", "line", "part"),
    [
        ("others: none", "others: all", 17, "unknown keeper of the other things 'all': expected one of book, none"),
        ("others: none\n", "", 13, "mug: several places; write `others: none`"),
        ("[on the countertop, on the desk]", "[]", 13, "0 places, expected 1 to 9"),
        ("[on the countertop, on the desk]", "[on the desk, on the desk]", 13, "is listed twice"),
        ("in the shelf in the kitchen", "in the shelf in the bath", 14, "a room cannot be given here"),
        ("laptop: on the desk", "mug: on the desk", 16, "mug is asked for twice (first at"),
        ("  - I work on the laptop till noon.\n", "", 15, "no sentence of 'habits' is about the laptop"),
    ],
)
def test_faults_of_places_and_things(old: str, new: str, line: int, part: str, tmp_path: Path) -> None:
    assert old in HOME
    with pytest.raises(DataError) as told:
        read(HOME.replace(old, new), tmp_path)
    lines = str(told.value).replace(f"{tmp_path}/", "").splitlines()
    assert any(f"x.yaml:{line}: " in one and part in one for one in lines), lines


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> OwnSet:
    folder = tmp_path_factory.mktemp("days")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(folder / "cache"))
        own_home._made.cache_clear()
        read(HOME, folder)
        found = own_set(folder / "x.yaml")
        load_house(found.name)
    return found


def test_each_day_has_all_things_and_each_is_asked_for(made: OwnSet) -> None:
    assert [e.target_category for e in made.episodes] == ["paperback_book"] * 2 + ["mug"] * 2 + ["bowl"] * 2
    for episode in made.episodes:
        check_home(episode, load_house(made.name))
        assert {o.category for o in episode.arrangement.objects} == {"paperback_book", "mug", "bowl", "laptop"}
        assert episode.habits_hash == made.dataset.sha256
    days = {e.seed: e.arrangement for e in made.episodes}
    assert len(days) == 2
    assert all(days[e.seed] == e.arrangement for e in made.episodes), "one arrangement a day"
    assert len({(e.seed, e.start) for e in made.episodes}) == 6


def test_the_robot_is_told_the_owners_sentences_alone(made: OwnSet) -> None:
    assert set(made.dataset.texts) == {
        line.removeprefix("  - ") for line in HOME.partition("habits:\n")[2].partition("requests")[0].splitlines()
    }
    assert all(len(e.entries) == 4 for e in made.episodes)
    (mug,) = made.dataset.entries_of("mug")
    assert mug.placements == (Placement("ontop", "countertop"), Placement("ontop", "desk"))
    assert [habit.supports for habit in mug.habits] == [(0, 1)]


def test_things_are_where_it_was_said(made: OwnSet) -> None:
    house = load_house(made.name)
    kitchen = next(number for number, room in enumerate(house.spec.rooms) if room.type == "kitchen")
    for episode in made.episodes:
        world = SceneState(house, episode.arrangement)
        by_name = {o.category: o for o in episode.arrangement.objects}
        assert house.instance_room[by_name["bowl"].anchor] == kitchen
        bed = by_name["paperback_book"].anchor
        turn = house.spec.items[bed].quarter_turns
        ahead = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][turn % 4])
        box = world.boxes[bed]
        assert (np.array(by_name["paperback_book"].position[:2]) - (box[:2] + box[3:5]) / 2) @ ahead > 0.4


def test_what_cannot_be_kept_there_is_told(tmp_path: Path) -> None:
    file = tmp_path / "x.yaml"
    file.write_text(HOME.replace("in the shelf in the kitchen", "in the armchair in the kitchen"))
    with pytest.raises(DataError, match="nothing is inside a armchair"):
        own_set(file)
    file.write_text(HOME.replace("in the shelf in the kitchen", "on the armchair in the kitchen"))
    with pytest.raises(DataError, match=r"the bowl cannot be kept there \(no armchair stands in that room\)"):
        own_set(file)
