"""Home files: reading, building, and messages about faults."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Any

import pytest

from ucon.core.errors import DataError, UconError
from ucon.envs.own_home import EXAMPLE
from ucon.habits.types import Placement
from ucon.scenes.home import build_program
from ucon.sim.cache import load_house
from ucon.task.own_home import building
from ucon.task.own_home.building import Unplaced, build, program_of_home, rooms_by_name, unplaced
from ucon.task.own_home.names import category_of, place_of, room_type_of
from ucon.task.own_home.reading import read_home
from ucon.task.own_home.sentences import shared_out
from ucon.task.own_home.wish import Sentence

SAID = "habits: [The mug is in the fridge.]\nrequests: [mug]\n"


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    load_house.cache_clear()


def read(text: str, tmp_path: Path) -> Any:
    file = tmp_path / "x.yaml"
    file.write_text(text)
    return read_home(file)


def faults(text: str, tmp_path: Path) -> str:
    with pytest.raises(DataError) as told:
        read(text, tmp_path)
    return str(told.value).replace(f"{tmp_path}/", "")


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("fridge", "fridge"),
        ("Top Cabinets", "top_cabinet"),
        ("dining table", "breakfast_table"),
        ("kitchen-table", "breakfast_table"),
        ("couch", "sofa"),
        ("frigde", None),
        ("", None),
    ],
)
def test_english_names_of_things(words: str, name: str | None) -> None:
    assert category_of(words) == name


@pytest.mark.parametrize(
    ("words", "room"),
    [
        ("kitchen", "kitchen"),
        ("living room", "living_room"),
        ("Bedroom 2", "bedroom"),
        ("Anna's bedroom", "bedroom"),
        ("bed room", "bedroom"),
        ("hall", "corridor"),
        ("small bathroom", "bathroom"),
        ("Anna", None),
        ("2", None),
    ],
)
def test_english_names_of_rooms(words: str, room: str | None) -> None:
    assert room_type_of(words) == room


@pytest.mark.parametrize(
    ("words", "relation", "anchor"),
    [
        ("in the top cabinet", "inside", "top_cabinet"),
        ("on top of my desk", "ontop", "desk"),
        ("Next to the laptop", "nextto", "laptop"),
        ("under bed", "under", "bed"),
        ("on the floor", "ontop", "floors"),
        ("nextto:laptop", "nextto", "laptop"),
        ("inside the dining table", "inside", "breakfast_table"),
    ],
)
def test_english_places(words: str, relation: Any, anchor: str) -> None:
    assert place_of(words) == Placement(relation, anchor)


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ("behind the sofa", "expected one of in, on, under, next to"),
        ("", "expected one of in"),
        ("on the tabel", "unknown thing 'tabel'"),
        ("on the shelf in the kitchen", "a room cannot be given here; leave ' in the kitchen' out"),
    ],
)
def test_places_that_are_none(words: str, part: str) -> None:
    assert part in str(place_of(words))


def test_sentences_go_to_what_they_name_or_with_the_one_before() -> None:
    texts = ("It rains.", "Her mug is red.", "It is hers alone.", "The teapot stays on the stove.", "It is hot.")
    found = shared_out([Sentence(text, "") for text in texts], ["mug", "teapot"])
    assert [one.text for one in found["mug"]] == list(texts[:3])
    assert [one.text for one in found["teapot"]] == list(texts[3:])


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        ("home: x\nroom: {kitchen: }\n" + SAID, 2, "unknown key 'room': did you mean rooms?"),
        (
            "rooms:\n  kitchen:\n    furniture: {frigde: 1}\n" + SAID,
            3,
            "unknown furniture 'frigde': did you mean fridge",
        ),
        ("rooms:\n  kitchen:\n    furniture: [television]\n" + SAID, 3, "near in meaning: standing_tv"),
        ("rooms:\n  kitchen: {furniture: {walls: 1}}\n" + SAID, 2, "walls is part of the building; leave it out"),
        ("rooms:\n  kitchen: {furniture: {fridge: 0}}\n" + SAID, 2, "fridge: '0', expected how many"),
        ("rooms:\n  kitchen: {furniture: {fridge: 31}}\n" + SAID, 2, "31 of fridge, expected at most 30"),
        ("rooms:\n  kitchen: {furniture: {sofa: 1, couch: 1}}\n" + SAID, 2, "sofa is listed twice"),
        ("rooms:\n  kitchen: [0.5, 3]\n" + SAID, 2, "expected two sides of 1.75 to 12 m"),
        ("rooms:\n  kitchen: wide\n" + SAID, 2, "size: 'wide', expected two sides"),
        ("rooms:\n  Gran's place:\n" + SAID, 2, "say its type: Gran's place: {type: bedroom}"),
        ("rooms:\n  - kitchen\n  - Kitchen\n" + SAID, 3, "room 'Kitchen' is listed twice"),
        ("rooms: [corridor]\n" + SAID, 1, "a home with only a corridor; add a room"),
        ("rooms: []\n" + SAID, 1, "no rooms; name some"),
        (
            "rooms: [kitchen, bedroom]\ndoors: [[kitchen, bedrom]]\n" + SAID,
            2,
            "unknown room 'bedrom': did you mean bedroom",
        ),
        (
            "rooms: [kitchen, bedroom]\ndoors: []\n" + SAID,
            2,
            "no door leads from kitchen to bedroom; add [kitchen, bedroom]",
        ),
        ("rooms: [kitchen, bedroom]\ndoors:\n- [kitchen, kitchen]\n" + SAID, 3, "joins it to itself; leave it out"),
        ("rooms: [kitchen, bedroom]\ndoors:\n- [kitchen, bedroom, gate]\n" + SAID, 3, "unknown kind of opening 'gate'"),
        ("kind: [a]\n" + SAID, 1, "kind of home: a list, expected a name"),
        ("home: [a]\n" + SAID, 1, "home: a list, expected a name"),
        ("rooms:\n  kitchen: {type: [a]}\n" + SAID, 2, "type: a list, expected a name"),
        ("rooms:\n  kitchen: [[a], 3]\n" + SAID, 2, "size: ['a list', 3], expected two sides"),
        ("rooms: [kitchen, bath]\ndoors: [[[a], bath]]\n" + SAID, 2, "door: a list, expected a name"),
        ("kind: castle\n" + SAID, 1, "unknown kind of home 'castle': expected one of flat"),
        ("seed: -1\n" + SAID, 1, "seed: '-1', expected a whole number from 0"),
        ("starts: 1.0\n" + SAID, 1, "starts: '1.0', expected a whole number from 1 to 100"),
        ("home: Rs_int\nrooms: [kitchen]\n" + SAID, 2, "Rs_int is an existing home"),
        ("home: Rs_int~x\n" + SAID, 1, "expected a whole number from 1, as in Rs_int~3"),
        ("home: [a]\n" + SAID, 1, "expected a name of at most 60 letters"),
        ("habits: [The mug is in bed.]\nrequests: [mugg]\n", 2, "unknown object 'mugg': did you mean mug?"),
        (
            "habits: [The mug is in bed.]\nrequests: {mug: inside the bed}\n",
            2,
            "mug: nothing is inside a bed; expected one of",
        ),
        ("habits: [The mug is in bed.]\nrequests: {mug: on the mug}\n", 2, "mug"),
        ("habits: [The mug is in bed.]\nrequests: [mug, mugs]\n", 2, "mug is asked for twice"),
        ("habits: [The mug is in bed.]\nrequests: [mug, kettle]\n", 2, "no sentence of 'habits' is about the kettle"),
        ("habits: [My_mug is in bed.]\nrequests: [mug]\n", 1, "an underscore in a sentence"),
        ("habits: [7]\nrequests: [mug]\n", 1, "habits: '7', expected a sentence"),
        ("habits: habts.txt\nrequests: [mug]\n", 1, "habts.txt cannot be read (No such file or directory)"),
        ("habits: ../x.yaml\nrequests: [mug]\n", 1, "expected a text file in the folder of this one"),
        ("habits: /etc/passwd\nrequests: [mug]\n", 1, "expected a text file in the folder of this one"),
        ("- a\n", 1, "expected a home"),
    ],
)
def test_a_fault_is_one_line_with_its_place(text: str, line: int, part: str, tmp_path: Path) -> None:
    told = faults(text, tmp_path)
    assert told.startswith(f"x.yaml:{line}: "), told
    assert part in told
    assert "\n" not in told
    assert "Marked(" not in told


def test_blank_rooms_are_drawn(tmp_path: Path) -> None:
    wish = read("rooms:\ndoors:\n" + SAID, tmp_path)
    assert (wish.rooms, wish.doors) == ((), None)


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    told = faults("sed: 1\nkind: x\nrooms: {a: }\n" + SAID, tmp_path).splitlines()
    assert told[0] == "x.yaml: 3 faults:"
    assert [line.partition(": ")[0] for line in sorted(told[1:])] == ["  x.yaml:1", "  x.yaml:2", "  x.yaml:3"]


def test_habits_of_a_file_beside_it(tmp_path: Path) -> None:
    (tmp_path / "habits.txt").write_text("# of my sister\r\n\r\nThe mug is in the fridge.\r\nIt is cold.\r\n")
    (request,) = read("habits: habits.txt\nrequests: mug\n", tmp_path).requests
    assert [(one.text, Path(one.where).name) for one in request.habits] == [
        ("The mug is in the fridge.", "habits.txt:3"),
        ("It is cold.", "habits.txt:4"),
    ]
    (tmp_path / "habits.txt").write_text("The mug is\tin the fridge.\n")
    assert faults("habits: habits.txt\nrequests: mug\n", tmp_path).startswith("habits.txt:1: a control character")
    (tmp_path / "outside").symlink_to("/etc/passwd")
    assert "in the folder of this one" in faults("habits: outside\nrequests: mug\n", tmp_path)


def test_hostile_sentences_stay_text(tmp_path: Path) -> None:
    hostile = [
        "${oc.env:HOME} mug",
        "{{ 7 * 7 }} mug",
        "!!python/object mug",
        "../../mug; rm -rf /",
        "<script>mug</script>",
    ]
    (request,) = read(f"habits: {[*hostile]!r}\nrequests: [mug]\n", tmp_path).requests
    assert [one.text for one in request.habits] == hostile


def test_whatever_a_file_says_it_is_read_or_refused(tmp_path: Path) -> None:
    """Values of every kind in place of the example's are either read, or refused in lines that name the file."""
    rng, lines = random.Random(0), EXAMPLE.read_text().splitlines()
    odd = [
        "[]",
        "{}",
        "7",
        "-1.5",
        "true",
        "~",
        "x",
        "[x, 1]",
        "{a: b}",
        "''",
        "[[]]",
        "kitchen",
        "{kitchen: {size: 3}}",
    ]
    for _ in range(150):
        changed = list(lines)
        for _ in range(rng.randint(1, 3)):
            k = rng.randrange(len(changed))
            key = changed[k].partition(":")[0]
            changed[k] = rng.choice([f"{key}: {rng.choice(odd)}", "", changed[rng.randrange(len(changed))]])
        try:
            read("\n".join(changed) + "\n", tmp_path)
        except UconError as error:
            told = str(error).splitlines()
            assert all("x.yaml" in line for line in told), told


def test_the_same_file_gives_the_same_home(tmp_path: Path) -> None:
    wish = read_home(EXAMPLE)
    program, called = program_of_home(wish)
    assert program == program_of_home(read_home(EXAMPLE))[0]
    assert called == {"kitchen_0": "kitchen", "bedroom_0": "bedroom"}
    assert program.edges == (("kitchen_0", "bedroom_0", "doorway"),)


def test_rooms_have_what_was_said_and_its_size(tmp_path: Path) -> None:
    wish = read_home(EXAMPLE)
    _, house = build(wish)
    spec = house.spec
    assert unplaced(wish, house) == []
    assert set(rooms_by_name(wish, house).values()) == {"kitchen", "bedroom"}
    for room, said in zip(spec.rooms, wish.rooms, strict=True):
        assert sorted((room.rect[2] - room.rect[0], room.rect[3] - room.rect[1])) == sorted(said.size_m or ())
        there = [item.category for item in spec.items if spec.rooms[item.room] is room]
        said_here = said.furniture or {}
        assert all(there.count(one) >= thing.count for one, thing in said_here.items())
        assert set(there) - said_here.keys() <= {"window", "electric_switch", "room_light", "door"}


def test_what_is_not_said_is_drawn(tmp_path: Path) -> None:
    wish = read("rooms: [kitchen, living room, bedroom, bath, hall]\nseed: 5\n" + SAID, tmp_path)
    program, _ = program_of_home(wish)
    assert program.hub == "corridor_0"
    assert len(program.edges) == 4
    kitchen = next(room for room in program.rooms if room.type == "kitchen")
    assert {"fridge", "sink", "oven"} <= kitchen.furniture.keys()
    whole, _ = program_of_home(read("seed: 5\n" + SAID, tmp_path))
    assert len(whole.rooms) >= 4
    for one in (program, whole):
        assert build_program("own:x:0123456789ab", one, 5).spec.rooms


def test_a_home_of_one_room(tmp_path: Path) -> None:
    _, house = build(read("rooms: {studio bedroom: [4, 5]}\n" + SAID, tmp_path))
    assert [room.type for room in house.spec.rooms] == ["bedroom"]


def test_what_finds_no_place_says_where_it_would(tmp_path: Path) -> None:
    wish = read(
        "rooms:\n  bath:\n    size: [2, 2.5]\n    furniture: {toilet: 1, piano: 1, sink: 4}\n  hall:\n" + SAID, tmp_path
    )
    _, house = build(wish)
    told = {one.category: str(one).replace(f"{tmp_path}/", "") for one in unplaced(wish, house)}
    assert told["piano"].startswith("x.yaml:4: bath: piano: it does not fit; there is room for it at size: [")
    assert "toilet" not in told
    for line in told.values():
        assert "\n" not in line


@pytest.mark.parametrize(
    ("wanted", "placed", "told"),
    [(1, 0, "it does not fit"), (3, 0, "none of the 3 fit"), (3, 2, "2 of 3 fit")],
)
def test_how_many_found_a_place(wanted: int, placed: int, told: str) -> None:
    assert str(Unplaced("bath", "wall_clock", wanted, placed, "x:1", "")) == f"x:1: bath: wall clock: {told}"


def test_what_is_said_to_fit_fits(tmp_path: Path) -> None:
    text = "rooms:\n  bath:\n    size: [3, 3]\n    furniture: {toilet: 1, bed: 3}\n  hall:\n" + SAID
    wish = read(text, tmp_path)
    (missing,) = unplaced(wish, build(wish)[1])
    placed = missing.placed
    assert 0 < placed < 3
    found = re.fullmatch(rf"there is room for all 3 at size: (\[.*\]); else write {placed}", missing.nearest)
    assert found
    for other in (text.replace("[3, 3]", found[1]), text.replace("bed: 3", f"bed: {placed}")):
        wish = read(other, tmp_path)
        assert unplaced(wish, build(wish)[1]) == []


def test_without_what_fits_nothing_is_built_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wish = read("rooms: {bath: {size: [1.75, 1.75], furniture: {bed: 5}}, hall: }\n" + SAID, tmp_path)
    _, house = build(wish)
    monkeypatch.setattr(building, "build_program", None)
    (missing,) = unplaced(wish, house, nearest=False)
    assert str(missing).endswith(" fit")
