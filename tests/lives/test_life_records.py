"""Records of requests: facts of a life survive storage, episodes keep their bytes, intervals resample lives."""

from __future__ import annotations

import json
import lzma
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from models.agents.frontier import FrontierAgent
from tests.evaluation.records import BASE, record
from tests.lives.short import short_life
from ucon.core.errors import DataError, EpisodeError
from ucon.core.untrusted.typed import read_as
from ucon.evaluation.figures.intervals import mean_interval, paired_difference, rate_interval
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.figures.units import lives_of
from ucon.evaluation.kept.naming import NameParts, agent_label, parts_of
from ucon.evaluation.kept.record import EpisodeRecord, read_records, to_lines
from ucon.lives.asked import Asked, asked_of, by_life, example
from ucon.lives.request_record import BelievedPlace, LifeFacts
from ucon.memory.map_memory import MapMemory
from ucon.memory.sightings_memory import SightingsMemory
from ucon.memory.simple_models import LastSeen
from ucon.perception.detectors.gt import GtDetector

ROOT = Path(__file__).parents[2]
FACTS = LifeFacts("home/0", 3, 1, 2, 0.333333, True, False, True)


def of_life(number: int, life: str = "home/0", **changes: Any) -> EpisodeRecord:
    return record(number, life=replace(FACTS, life=life, request=number), **changes)


def test_facts_of_a_life_go_to_a_line_and_back(tmp_path: Path) -> None:
    records = [of_life(0), replace(of_life(1), life=replace(FACTS, request=1, seen_days_ago=None, moved=None))]
    (tmp_path / "episodes.jsonl").write_text(to_lines(records))
    assert read_records(tmp_path) == records
    assert json.loads(records[1].to_line())["life"] == {
        "life": "home/0", "request": 1, "day": 1, "slot": 2, "seen_days_ago": None, "moved": None, "obeys": False,
        "changed": True,
    }  # fmt: skip


def test_records_of_episodes_keep_their_bytes() -> None:
    assert "life" not in BASE.to_json()
    path = sorted((ROOT / "results").glob("*/episodes.jsonl.xz"))[0]
    lines = lzma.decompress(path.read_bytes()).decode().splitlines()[:20]
    assert lines
    for line in lines:
        stored = EpisodeRecord.from_json(json.loads(line))
        assert stored.life is None
        assert stored.to_line() == line


@pytest.mark.parametrize(
    "life",
    [
        5,
        "home/0",
        [],
        {},
        {"seen_days_ago": 1},
        {"seen_days_ago": "1.0"},
        {"moved": 0},
        {"obeys": None},
        {"changed": "no"},
        {"request": 1.0},
        {"day": True},
        {"life": None},
        {"mood": "good"},
    ],
)
def test_a_wrong_type_inside_a_life_is_refused_in_one_line(tmp_path: Path, life: Any) -> None:
    data = json.loads(of_life(0).to_line())
    data["life"] = data["life"] | life if isinstance(life, dict) and life else life
    (tmp_path / "episodes.jsonl").write_text(json.dumps(data) + "\n")
    with pytest.raises(DataError, match=r"episodes\.jsonl:1: life=.*: expected an object with life, request") as raised:
        read_records(tmp_path)
    assert "\n" not in str(raised.value)


def test_a_missing_fact_is_refused() -> None:
    data = json.loads(of_life(0).to_line())
    del data["life"]["moved"]
    with pytest.raises(DataError, match="expected an object with life, request"):
        EpisodeRecord.from_json(data)


@dataclass(frozen=True)
class _Inner:
    n: int


@dataclass(frozen=True)
class _Outer:
    inner: _Inner
    others: tuple[_Inner, ...]
    perhaps: _Inner | None


def test_dataclasses_within_dataclasses_are_read() -> None:
    data = {"inner": {"n": 1}, "others": [{"n": 2}, {"n": 3}], "perhaps": None}
    assert read_as(_Outer, data, "x:1", "one") == _Outer(_Inner(1), (_Inner(2), _Inner(3)), None)
    for wrong in ({"inner": None}, {"inner": {"n": 1.0}}, {"others": [{"n": 2}, {}]}, {"perhaps": {"n": 1, "m": 2}}):
        with pytest.raises(DataError, match=rf"^x:1: {next(iter(wrong))}=.*: expected an object with n; "):
            read_as(_Outer, data | wrong, "x:1", "one")


def test_intervals_of_lives_draw_lives() -> None:
    """Ten lives in which all requests end alike: forty requests carry no more information than ten."""
    records = [of_life(k, f"home/{k // 4}", success=k // 4 % 2 == 0) for k in range(40)]
    lives = lives_of(records)
    assert lives == [f"home/{k // 4}" for k in range(40)]
    found, figures = [r.success for r in records], summarise(records)
    assert figures["success_rate_ci95"] == list(rate_interval(found, clusters=lives).ci95)
    assert figures["spl_ci95"] == list(mean_interval([r.spl for r in records], clusters=lives).ci95)
    alone = summarise([replace(r, life=None) for r in records])
    assert alone["success_rate_ci95"] == list(rate_interval(found).ci95)
    width, width_alone = (f["success_rate_ci95"][1] - f["success_rate_ci95"][0] for f in (figures, alone))
    assert width > 1.6 * width_alone


def test_differences_of_lives_draw_lives() -> None:
    first = [of_life(k, f"home/{k // 4}", success=k // 4 % 2 == 0) for k in range(40)]
    second = [of_life(k, f"home/{k // 4}", success=False) for k in range(40)]
    clusters = [r.life.life for r in sorted(first, key=lambda r: r.episode) if r.life is not None]
    pairs = sorted(zip(first, second, strict=True), key=lambda pair: pair[0].episode)
    found, others = ([float(pair[k].success) for pair in pairs] for k in range(2))
    drawn = compare_records(first, second).differences["success_rate"]
    assert drawn == paired_difference(found, others, clusters=clusters)
    assert drawn != paired_difference(found, others)


def test_episodes_are_drawn_alone_also_beside_lives() -> None:
    assert lives_of([record(0), record(1)]) is None
    assert lives_of([record(0), of_life(1)]) is None
    assert lives_of([]) is None


def test_the_label_names_the_memory() -> None:
    def label(memory: Any) -> str:
        return agent_label({"agent": "frontier"} | parts_of(FrontierAgent(), GtDetector(), memory).to_json())

    assert label(None) == "frontier"
    assert label(MapMemory()) == "frontier + memory of map"
    assert label(SightingsMemory()) == "frontier + memory of map and sightings"
    assert label(SightingsMemory(LastSeen())) == "frontier + memory of map and last seen"
    assert "memory" not in NameParts().to_json()


def test_who_reads_no_habits_plays_by_their_news_where_the_memory_does() -> None:
    """Runs at different habit levels are the same only if neither agent nor memory uses habits."""

    def uses(memory: Any) -> bool:
        return parts_of(FrontierAgent(), GtDetector(), memory).uses_habits

    assert uses(SightingsMemory())
    for memory in (None, MapMemory(), SightingsMemory(LastSeen()), SightingsMemory(recalls=False, acquires=True)):
        assert not uses(memory)


BELIEVED = (BelievedPlace("on the sofa", 0.75, 1.5, -2.0, 0.4), BelievedPlace("", 0.1, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("believed", [None, (), BELIEVED])
def test_believed_places_go_to_a_line_and_back(tmp_path: Path, believed: Any) -> None:
    records = [replace(of_life(0), believed=believed)]
    (tmp_path / "episodes.jsonl").write_text(to_lines(records))
    assert read_records(tmp_path) == records
    assert ("believed" in records[0].to_json()) == (believed is not None)


@pytest.mark.parametrize(
    "believed",
    [5, "sofa", {}, [5], [{}], [{"words": 1}], [{"p": "0.5"}], [{"p": 1}], [{"x": None}], [{"mood": "good"}],
     [{"p": float("nan")}], [{"p": 1.5}], [{"p": -0.1}], [{"z": float("inf")}]],
)  # fmt: skip
def test_a_believed_place_that_cannot_be_is_refused_in_one_line(tmp_path: Path, believed: Any) -> None:
    data = json.loads(replace(of_life(0), believed=BELIEVED[:1]).to_line())
    if isinstance(believed, list) and believed and isinstance(believed[0], dict) and believed[0]:
        believed = [data["believed"][0] | believed[0]]
    data["believed"] = believed
    (tmp_path / "episodes.jsonl").write_text(json.dumps(data) + "\n")
    with pytest.raises(DataError, match=r"episodes\.jsonl:1: ") as raised:
        read_records(tmp_path)
    assert "\n" not in str(raised.value)


def test_requests_of_a_life_stay_together_and_in_order() -> None:
    a, b = short_life(1, requests=3), short_life(3, requests=2)
    asked = asked_of([a, b])
    assert [one.id for one in asked] == [f"{a.id}/000", f"{a.id}/001", f"{a.id}/002", f"{b.id}/000", f"{b.id}/001"]
    jobs = list(enumerate(asked))
    mixed = [jobs[0], jobs[3], jobs[1], jobs[4], jobs[2]]
    assert by_life(mixed) == [jobs[:3], jobs[3:]]
    with pytest.raises(EpisodeError, match=rf"life {a.id}: requests \[2, 0\], expected them in order"):
        by_life([jobs[2], jobs[0]])
    assert {one.hash for one in asked} == {a.hash, b.hash}


def test_an_example_of_a_request_begins_at_the_dock() -> None:
    life = short_life()
    episode = example(Asked(life, 2))
    assert (episode.start, episode.id) == (life.dock, Asked(life, 2).id)
    assert episode.target_category == life.possessions[life.requests[2].possession].category
