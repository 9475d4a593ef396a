"""Verdicts for imported files: really tried, kept by home, shared between files, and used by the sampler."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from ucon.configuration.wiring import official_habits
from ucon.core.errors import DataError
from ucon.generation.kept import kept_folder, tried
from ucon.generation.validate import try_triple
from ucon.habits import HabitDataset, ImportReport, official
from ucon.habits.verdicts import Triple
from ucon.objects.catalogue import catalogue
from ucon.sim.cache import load_house
from ucon.sim.render import RasterRenderer
from ucon.task.making.placeable import Unplaced, counted, unplaced
from ucon.task.making.sampler import EpisodeSampler

HOME = "Rs_int"
SHARED = Path(__file__).resolve().parents[2] / "../shared"
RELEASE, TRIPLES = SHARED / "official_release/task", SHARED / "facts/relations_triples.csv"


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ucon.generation.kept.user_cache", lambda: tmp_path / "cache")


def write(folder: Path, *triples: str, scene: str = HOME, name: str = "task.json") -> Path:
    """Write a file with one task per target; each triple is a location, as in ``mug nextto tray``."""
    tasks: dict[str, list[str]] = {}
    for triple in triples:
        target, relation, anchor = triple.split()
        tasks.setdefault(target, []).append(f"{target}.place_{relation}({anchor})")
    rows = [
        {"basic_object_name": target, "habits": ["Keeps it in its place."], "location": places}
        for target, places in tasks.items()
    ]
    path = folder / name
    path.write_text(json.dumps({scene: rows}))
    return path


def read(path: Path) -> tuple[HabitDataset, ImportReport]:
    return official(path, catalogue().names)


def judged(path: Path) -> tuple[dict[str, int], list[Unplaced], int]:
    """Counts, refusals, and the number of triples that were tried."""
    dataset, report = read(path)
    totals: list[int] = [0]
    verdicts = tried(dataset, workers=1, progress=lambda _, total: totals.append(total))
    rest = unplaced(report.located, verdicts)
    return counted(report.located, rest), rest, totals[-1]


LOCATIONS = (
    "mug ontop breakfast_table",
    "mug nextto tray",  # its anchor is imported
    "mug nextto swing",
    "mug inside walls",
    "mug inside breakfast_table",
    "bathtub nextto sofa",
    "coffee_cup ontop towel_rack",
)


def test_every_location_gets_the_verdict_of_really_trying_it(tmp_path: Path) -> None:
    path = write(tmp_path, *LOCATIONS)
    counts, rest, count = judged(path)
    assert counts == {"placed": 2, "imported": 1, "implausible": 4, "absent_anchor": 1, "never_seen": 0}
    assert count == len(LOCATIONS)
    assert [(one.where.rpartition("task.json: ")[2], one.reason) for one in rest] == [
        ("Rs_int[0].location[2]", "absent_anchor"),
        ("Rs_int[0].location[3]", "implausible"),
        ("Rs_int[0].location[4]", "not_a_container"),
        ("Rs_int[1].location[0]", "implausible"),
        ("Rs_int[2].location[0]", "no_free_slot"),
    ]
    assert "bathtub is fixed" in rest[3].message
    assert "towel_rack of Rs_int" in rest[4].message
    again, same, count = judged(path)
    assert (again, same, count) == (counts, rest, 0), "nothing is tried twice"


def test_files_share_what_was_tried(tmp_path: Path) -> None:
    judged(write(tmp_path, *LOCATIONS[:2]))
    _, _, count = judged(write(tmp_path, *LOCATIONS[:3], name="task_nodoor.json"))
    assert count == 1
    _, _, count = judged(write(tmp_path, LOCATIONS[0], scene="Benevolence_0_int", name="task_other.json"))
    assert count == 1, "another home"


def test_an_interrupted_import_goes_on(tmp_path: Path) -> None:
    dataset, _ = read(write(tmp_path, *LOCATIONS[:2]))

    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tried(dataset, workers=1, progress=interrupt)
    blocks = list((kept_folder() / "blocks").iterdir())
    assert len(blocks) == 1
    before = blocks[0].stat().st_mtime_ns
    assert tried(dataset, workers=1).of
    assert blocks[0].stat().st_mtime_ns == before


def test_a_damaged_verdict_file_is_named(tmp_path: Path) -> None:
    dataset, _ = read(write(tmp_path, LOCATIONS[0]))
    tried(dataset, workers=1)
    path = kept_folder() / f"{HOME}.json"
    path.write_text("[[1, 2]]")
    with pytest.raises(DataError, match=rf"{HOME}\.json: not a list of verdicts; remove the file"):
        tried(dataset, workers=1)


NEVER_SEEN: tuple[str, Triple] = ("Beechwood_0_int", ("envelope", "inside", "top_cabinet"))


def test_what_nobody_can_see_is_not_placed(tmp_path: Path) -> None:
    scene, triple = NEVER_SEEN
    counts, rest, _ = judged(write(tmp_path, " ".join(triple), scene=scene))
    assert (counts["never_seen"], counts["placed"]) == (1, 0)
    assert "nobody in reach can see it" in rest[0].message


def test_an_anchor_is_brought_to_more_than_one_place() -> None:
    house, eyes = load_house("Benevolence_0_int"), RasterRenderer()
    triple = ("bottle_of_sunscreen", "inside", "paper_bag")
    assert "paper_bag" not in house.categories
    assert try_triple(house, triple, eyes) is not None
    assert try_triple(house, triple, eyes, spots=4) is None


def test_sampling_goes_by_shapes_whatever_was_tried_before(tmp_path: Path) -> None:
    path = write(tmp_path, *LOCATIONS, "bathtub nextto bed", "coffee_cup ontop breakfast_table")
    before = official_habits(str(path))
    assert before.verdicts.refusal(("bathtub", "nextto", "sofa"), HOME) == "implausible"
    assert before.verdicts.refusal(("coffee_cup", "ontop", "towel_rack"), HOME) is None
    assert EpisodeSampler(before).target_categories(HOME) == ("coffee_cup", "mug")
    _, rest, _ = judged(path)
    assert any("towel_rack" in one.message for one in rest), "trying it says more"
    after = official_habits(str(path))
    assert after.verdicts.to_json() == before.verdicts.to_json()
    assert EpisodeSampler(after).target_categories(HOME) == ("coffee_cup", "mug")


@pytest.mark.slow
@pytest.mark.skipif(not (RELEASE.is_dir() and TRIPLES.is_file()), reason="the official release's files are not at hand")
def test_nineteen_in_twenty_of_what_should_fit_is_realised_in_its_scene() -> None:
    """All locations of the release are really tried in the homes they name; about a minute of CPU time."""
    with TRIPLES.open(newline="") as file:
        fits = {(r["target"], r["relation"], r["anchor"]) for r in csv.DictReader(file) if r["verdict"] == "ok"}
    dataset, report = read(RELEASE)
    refused = {one.where for one in unplaced(report.located, tried(dataset, workers=2))}
    wanted = [o for o in report.located if (o.category, o.placement.relation, o.placement.anchor) in fits]
    assert len(wanted) > 7000
    assert sum(one.where not in refused for one in wanted) >= 0.95 * len(wanted)
