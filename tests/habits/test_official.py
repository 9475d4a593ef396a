"""Reader of the official release: exact counts if it is available, and made-up files for every malformed case."""

import json
from pathlib import Path

import pytest

from ucon.core.errors import DataError
from ucon.habits import book, household, official
from ucon.objects.catalogue import catalogue

RELEASE = Path(__file__).resolve().parents[2] / "../shared/official_release/task"
needs_release = pytest.mark.skipif(not RELEASE.is_dir(), reason="the official release's files are not at hand")


def task(**changes):
    found = {
        "user_instruction": "Find it.",
        "basic_object_name": "wallet",
        "prompt": "",
        "habits": ["Keeps it on the desk.", "Never in the hall."],
        "location": ["wallet.place_ontop(desk)", "wallet.place_inside(tote)"],
    }
    return {key: value for key, value in (found | changes).items() if value is not ...}


def read(tmp_path, content):
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps(content))
    return official(path, catalogue().names)


@needs_release
def test_release_counts():
    data, report = official(RELEASE, catalogue().names)
    assert (report.scenes, report.categories, report.tasks) == (20, 420, 1_642)
    assert (report.habits, report.locations, len(data)) == (18_374, 8_665, 18_374)
    assert len(report.problems) == 7
    assert all("itself" in p.message for p in report.problems)
    assert sum(len(e.placements) for e in data.entries) == 8_665 - 7
    assert not data.labelled


@needs_release
def test_release_households_and_list_form():
    data, _ = official(RELEASE)
    own = household("Rs_int~3", data)
    assert {e.scene for entries in own.values() for e in entries} == {"Rs_int"}
    assert household("procedural:house:1", data) == household("procedural:house:1", data)
    listed, report = official(RELEASE / "test.json", catalogue().names)
    assert (report.scenes, report.tasks, report.habits, len(listed.entries)) == (1, 10, 93, 10)


def test_what_stands_in_the_scenes_is_read_from_the_list_beside(tmp_path):
    content = {"Rs_int": {"wallet": [task()]}, "Merom_0_int": {"wallet": [task()]}}
    without, _ = read(tmp_path, content)
    assert without.standing == {}
    (tmp_path / "scene_obj.json").write_text(json.dumps({"Rs_int": ["sofa", "desk", "sofa"], "Other_int": []}))
    with_list, _ = read(tmp_path, content)
    assert with_list.standing == {"Rs_int": ("desk", "sofa")}
    assert with_list.sha256 == without.sha256
    for wrong in ({"Rs_int": "desk"}, {"Rs_int": [3]}, []):
        (tmp_path / "scene_obj.json").write_text(json.dumps(wrong))
        with pytest.raises(DataError, match=r"scene_obj\.json"):
            read(tmp_path, content)


def test_both_forms(tmp_path):
    by_category, _ = read(tmp_path, {"Rs_int": {"wallet": [task(), task()]}})
    listed, report = read(tmp_path, {"Rs_int": [task(), task()]})
    assert by_category.sha256 == listed.sha256
    assert [e.id for e in listed.entries] == ["Rs_int/wallet/0", "Rs_int/wallet/1"]
    assert not report.problems
    assert book().sha256 != listed.sha256


MALFORMED = {
    "not a task": ("x", "> wallet[1]: text, expected an object"),
    "no target": (task(basic_object_name=...), "> wallet[1]: basic_object_name is null"),
    "other category": (task(basic_object_name="kettle"), "'kettle' is listed under 'wallet'"),
    "unknown target": (task(basic_object_name="walet"), "unknown target category 'walet'"),
    "no habits": (task(habits=...), "> wallet[1]: habits is null, expected a list"),
    "habits as text": (task(habits="a, b"), "habits is text"),
    "habit not text": (task(habits=["Keeps it.", 7]), "wallet[1].habits[1]: int"),
    "empty habit": (task(habits=["Keeps it.", " "]), "wallet[1].habits[1]"),
    "no locations": (task(location=[]), "0 usable locations"),
    "bad location": (task(location=["desk", "wallet.place_inside(tote)"]), "wallet[1].location[0]: 'desk', expected"),
    "unknown relation": (task(location=["wallet.place_above(desk)"]), "unknown relation 'above'"),
    "itself": (task(location=["wallet.place_ontop(wallet)"]), "placed ontop itself"),
    "other target": (task(location=["kettle.place_ontop(desk)"]), "location of 'kettle'"),
    "unknown anchor": (task(location=["wallet.place_ontop(desc)"]), "unknown anchor category 'desc'"),
    "twice": (task(location=["wallet.place_ontop(desk)"] * 2), "location[1]: 'ontop desk' is listed twice"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_malformed_is_reported_with_file_and_position(tmp_path, case):
    bad, message = MALFORMED[case]
    data, report = read(tmp_path, {"Rs_int": {"wallet": [task(), bad]}})
    assert len(data.entries) >= 1
    assert any(message in str(p) and "tasks.json: Rs_int > wallet" in str(p) for p in report.problems), report.problems


def test_what_is_left_out_is_counted(tmp_path):
    bad = task(habits=["Keeps it.", 7, "x" * 3000], location=["wallet.place_ontop(desk)", None, "desk"])
    data, report = read(tmp_path, {"Rs_int": {"wallet": [task(), bad, task(basic_object_name=None)]}})
    assert (report.habits, len(data)) == (2 + 3 + 2, 2 + 1)
    assert (report.locations, len(report.located)) == (2 + 3 + 2, 2 + 1)


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        (b'{"Rs_int": {"wallet": [', "tasks.json:1:"),
        (b'{"Rs_int": "\xff"}', "not UTF-8"),
        (b"[]", "list at the top"),
        (b"{}", "object at the top"),
        (b'{"Rs_int": {"wallet": 3}}', "no usable task"),
        (b"[" * 100_000, "tasks.json"),
    ],
)
def test_unusable_files(tmp_path, raw, message):
    path = tmp_path / "tasks.json"
    path.write_bytes(raw)
    with pytest.raises(DataError) as caught:
        official(path)
    assert message in str(caught.value)
    assert "tasks.json" in str(caught.value)
    with pytest.raises(DataError, match="cannot be read"):
        official(tmp_path / "none.json")
