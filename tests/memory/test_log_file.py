"""A memory as a file: written, read, mended by hand, refused where it cannot be."""

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
    log.saw("coffee_cup", np.array([0.5, 0.25, 1.2]), time_of(2, 2))
    return log


def test_a_memory_comes_back_and_recalls_the_same(log, tmp_path):
    path = tmp_path / "mug.json"
    save_log(log, path, HOME)
    again = load_log(path, HOME)
    assert again.last() == log.last() == time_of(2, 2)
    for name, thing in log.things.items():
        assert (again.things[name].seen, again.things[name].absent) == (thing.seen, thing.absent)
        np.testing.assert_allclose(again.things[name].places, thing.places)
        now = PlaceModel().now(thing, time_of(4, 1))
        np.testing.assert_array_equal(PlaceModel().now(again.things[name], time_of(4, 1)), now)
    save_log(again, tmp_path / "again.json", HOME)
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_a_person_can_read_it(log, tmp_path):
    save_log(log, tmp_path / "mug.json", HOME)
    text = (tmp_path / "mug.json").read_text()
    assert '"mug": {"places": [[1.0, 2.0, 0.9], [4.0, -2.0, 0.4]], "seen": [["day 0, midday", 0]' in text
    assert len(text.splitlines()) == 4


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda d: d.update(format=1), "memory format 1, expected 2"),
        (lambda d: d.update(home="another"), "memory of home 'another', expected lives_mini/x/00"),
        (lambda d: d.pop("things"), "expected an object with format, home and things"),
        (lambda d: d["things"].update(unicorn=d["things"].pop("mug")), "unicorn: no such category"),
        (lambda d: d["things"]["mug"].pop("absent"), "expected places, seen and absent"),
        (lambda d: d["things"]["mug"]["places"].append([0, 1]), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["places"].append([0, 1, 1e9]), "expected x, y, z in metres"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, noon", 0]), "expected morning, midday, evening"),
        (lambda d: d["things"]["mug"]["seen"].append(["yesterday", 0]), "expected 'day 3, evening'"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 9, evening", 7]), "expected a time and a place below 2"),
        (lambda d: d["things"]["mug"]["seen"].append(["day 1, evening", 0]), "a clock goes forward"),
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
    with pytest.raises(DataError, match="mend the file"):
        load_log(tmp_path / "cut.json", HOME)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"missing\.json"):
        load_log(tmp_path / "missing.json", HOME)
