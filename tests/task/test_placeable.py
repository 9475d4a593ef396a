"""Which placements of an imported dataset can be realised: every one counted, each refusal with file and position."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from ucon.habits import official
from ucon.objects.catalogue import catalogue
from ucon.task.making.placeable import ABSENT, Unplaced, counted, unplaced

RELEASE = Path(__file__).resolve().parents[2] / "../shared/official_release/task"


def read(tmp_path: Path, scene: str, *locations: str) -> tuple[int, list[Unplaced]]:
    """The number of placements in a made-up task, and those that cannot be realised."""
    task = {"basic_object_name": "mug", "habits": ["Keeps it there."], "location": list(locations)}
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps({scene: {"mug": [task]}}))
    _, report = official(path, catalogue().names)
    return len(report.located), unplaced(report.located)


def test_every_refusal_names_its_position_and_reason(tmp_path: Path) -> None:
    count, found = read(
        tmp_path,
        "Rs_int",
        "mug.place_ontop(breakfast_table)",
        "mug.place_nextto(mug)",  # malformed, so not counted here
        "mug.place_inside(breakfast_table)",
        "mug.place_nextto(tray)",  # its anchor is imported
        "mug.place_nextto(swing)",
        "mug.place_ontop(ceilings)",
        "mug.place_nextto(walls)",
    )
    assert count == 6
    assert [(one.where.rpartition("tasks.json: ")[2], one.reason) for one in found] == [
        ("Rs_int > mug[0].location[2]", "not_a_container"),
        ("Rs_int > mug[0].location[4]", ABSENT),
        ("Rs_int > mug[0].location[5]", "implausible"),
    ]
    assert "no swing in Rs_int" in str(found[1])
    assert [one.group for one in found] == ["implausible", "absent_anchor", "implausible"]


def test_the_verdicts_add_up(tmp_path: Path) -> None:
    locations = ("mug.place_ontop(breakfast_table)", "mug.place_nextto(tray)", "mug.place_nextto(swing)")
    task = {"basic_object_name": "mug", "habits": ["Keeps it there."], "location": list(locations)}
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps({"Rs_int": [task], "Rs_imt": [task]}))
    _, report = official(path, catalogue().names)
    counts = counted(report.located, unplaced(report.located))
    assert counts == {"placed": 2, "imported": 1, "implausible": 0, "absent_anchor": 4, "never_seen": 0}


def test_a_scene_that_does_not_exist_is_named(tmp_path: Path) -> None:
    _, found = read(tmp_path, "Rs_imt", "mug.place_ontop(breakfast_table)")
    assert found[0].reason == ABSENT
    assert "did you mean Rs_int" in found[0].message


@pytest.mark.skipif(not RELEASE.is_dir(), reason="the official release's files are not at hand")
def test_the_official_release() -> None:
    _, report = official(RELEASE, catalogue().names)
    reasons = Counter(one.reason for one in unplaced(report.located))
    assert len(report.located) + len(report.problems) == report.locations
    assert 0.80 <= 1 - reasons.total() / report.locations <= 0.90
    assert reasons[ABSENT] < 0.03 * report.locations
