"""A memory as a file: written, read, corrected by hand, and refused if impossible."""

import json

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.lives.clock import time_of
from ucon.memory.log_file import load_log, save_log
from ucon.memory.place_model import PlaceModel
from ucon.memory.sighting_log import SightingLog

HOME = "lives_mini/x/00"


@pytest.fixture
def log():
    log = SightingLog()
    log.saw("mug", np.array([1.0, 2.0, 0.9]), time_of(0, 1))
    log.saw("mug", np.array([4.0, -2.0, 0.4]), time_of(2, 0))
    log.missed("mug", 0, time_of(2, 2))
    log.saw("coffee_cup", np.array([0.5, 0.25, 1.2]), time_of(2, 2), (("ontop", "shelf"), ("nextto", "mug")))
    return log


def test_a_memory_comes_back_and_recalls_the_same(log, tmp_path):
    path = tmp_path / "mug.json"
    save_log(log, path, HOME)
    again = load_log(path, HOME)
    assert again.last() == log.last() == time_of(2, 2)
    for name, thing in log.things.items():
        assert (again.things[name].seen, again.things[name].absent) == (thing.seen, thing.absent)
        np.testing.assert_allclose(again.things[name].places, thing.places)
        assert again.things[name].spots == thing.spots
        now = PlaceModel().now(thing, time_of(4, 1))
        np.testing.assert_array_equal(PlaceModel().now(again.things[name], time_of(4, 1)), now)
    save_log(again, tmp_path / "again.json", HOME)
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_a_person_can_read_it(log, tmp_path):
    save_log(log, tmp_path / "mug.json", HOME)
    text = (tmp_path / "mug.json").read_text()
    assert '"mug": {"places": [[1.0, 2.0, 0.9], [4.0, -2.0, 0.4]], "seen": [["day 0, midday", 0]' in text
    assert '"places": [[0.5, 0.25, 1.2, "ontop", "shelf", "nextto", "mug"]]' in text
    assert len(text.splitlines()) == 4


def test_sizes_come_back_where_the_detector_erred(log, tmp_path):
    path = tmp_path / "mug.json"
    log.saw("mug", np.array([1.0, 2.0, 0.9]), time_of(3, 0), size=np.array([0.08, 0.09, 0.1]))
    log.saw_again("mug", 0, time_of(3, 1))
    save_log(log, path, HOME)
    again = load_log(path, HOME).things
    assert again["mug"].size.tolist() == [[0.08, 0.09, 0.1], [0.0, 0.0, 0.0]]
    assert again["mug"].seen[-1] == (time_of(3, 1), 0)
    assert again["coffee_cup"].size.tolist() == [[0.0, 0.0, 0.0]]
    assert path.read_text().count("sizes") == 1


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        *[
            (lambda d, sizes=sizes: d["things"]["mug"].update(sizes=sizes), "expected three sides in metres")
            for sizes in ([], [[0.1, 0.1, 0.1]], [[0.1, 0.1], [0.1, 0.1]], [[0.1, 0.1, -1]] * 2, [["a", 1, 1]] * 2)
        ],
        (lambda d: d["things"]["mug"].update(sizes={}), "expected a list"),
        (lambda d: d.update(format=1), "memory format 1, expected 2"),
        (lambda d: d.update(format="2"), "memory format '2', expected 2"),
        (lambda d: d.update(things=[]), "expected an object with format, home and things"),
        (lambda d: d["things"].update(mug=[]), "expected places, seen and absent"),
        (lambda d: d["things"].update({"a\nmug": {}}), "no such category"),
        *[
            (lambda d, more=more: d["things"]["mug"]["places"].append([0, 1, 2, *more]), said)
            for more, said in (
                (("ontop",), "relations and anchors"),
                (("ontop", "shelf", "nextto"), "relations and anchors"),
                (("ontop", "shelf") * 3, "relations and anchors"),
                (("above", "shelf"), "expected one of ontop, inside"),
                (("ontop", "unicorn"), "and a category"),
                (("shelf", "ontop"), "and a category"),
                (("ontop", ["shelf"]), "and a category"),
                ((["ontop"], "shelf"), "and a category"),
                (("ontop", None), "and a category"),
            )
        ],
        (lambda d: d["things"]["mug"]["places"].append([0, 1, True]), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["places"].append({"x": 0}), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["places"].extend([[0, 1, 2]] * 2000), "expected a list of at most 2000"),
        (lambda d: d["things"]["mug"]["seen"].extend([["day 9, evening", 0]] * 2000), "a list of at most 2000"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9999999, evening", 0]), "expected morning, midday, evening"),
        (lambda d: d["things"]["mug"]["seen"].append(["day -1, evening", 0]), "expected 'day 3, evening'"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, evening", -1]), "expected a time and a place below 2"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, evening", True]), "expected a time and a place below 2"),
        (lambda d: d.update(home="another"), "memory of home 'another', expected lives_mini/x/00"),
        (lambda d: d.pop("things"), "expected an object with format, home and things"),
        (lambda d: d["things"].update(unicorn=d["things"].pop("mug")), "unicorn: no such category"),
        (lambda d: d["things"]["mug"].pop("absent"), "expected places, seen and absent"),
        (lambda d: d["things"]["mug"]["places"].append([0, 1]), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["places"].append([0, 1, 1e9]), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, noon", 0]), "expected morning, midday, evening"),
        (lambda d: d["things"]["mug"]["seen"].append(["yesterday", 0]), "expected 'day 3, evening'"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, evening", 7]), "expected a time and a place below 2"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 1, evening", 0]), "times must not go back"),
        (lambda d: d["things"]["mug"].update(seen={}), "expected a list"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(log, tmp_path, edit, said):
    path = tmp_path / "mug.json"
    save_log(log, path, HOME)
    data = json.loads(path.read_text())
    edit(data)
    path.write_text(json.dumps(data))
    with pytest.raises(DataError) as raised:
        load_log(path, HOME)
    assert said in str(raised.value)
    assert str(path) in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("text", ["", "[1]", "{", '{"format": NaN}'])
def test_a_cut_file_is_refused(tmp_path, text):
    (tmp_path / "cut.json").write_text(text)
    with pytest.raises(DataError, match="fix the file"):
        load_log(tmp_path / "cut.json", HOME)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999", "1" * 400])
def test_numbers_that_are_none_are_refused(log, tmp_path, number):
    path = tmp_path / "mug.json"
    save_log(log, path, HOME)
    path.write_text(path.read_text().replace("[1.0, 2.0, 0.9]", f"[1.0, {number}, 0.9]"))
    with pytest.raises(DataError, match=r"mug\.json") as raised:
        load_log(path, HOME)
    assert "\n" not in str(raised.value)


def test_every_cut_is_refused(log, tmp_path):
    path = tmp_path / "mug.json"
    save_log(log, path, HOME)
    whole = path.read_text().rstrip()
    for length in range(0, len(whole), 7):
        path.write_text(whole[:length])
        with pytest.raises(DataError, match=r"mug\.json") as raised:
            load_log(path, HOME)
        assert "\n" not in str(raised.value)


def test_a_huge_file_is_not_read(tmp_path):
    path = tmp_path / "mug.json"
    with path.open("wb") as file:
        file.truncate(17 * 2**20)
    with pytest.raises(DataError, match=r"mug\.json.*at most 16,777,216") as raised:
        load_log(path, HOME)
    assert "\n" not in str(raised.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"missing\.json"):
        load_log(tmp_path / "missing.json", HOME)
