"""Distance closed and carry-over: by hand on few records, and their intervals on many."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.evaluation.records import record
from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.evaluation.figures.gap_closed import carried_over, distance_closed
from ucon.evaluation.figures.markdown import Run, markdown_page
from ucon.evaluation.kept.record import EpisodeRecord, to_lines


def played(found: list[bool], **changes: Any) -> list[EpisodeRecord]:
    spl = {"spl": 0.5, "success_150": True}
    return [record(i, success=one, **({**changes, **spl} if one else changes)) for i, one in enumerate(found)]


def test_the_share_of_the_way() -> None:
    start, goal = played([True] + [False] * 9, contained=True), played([True] * 9 + [False], contained=True)
    run = played([True] * 5 + [False] * 5, contained=True)
    for share in distance_closed(run, start, goal).values():
        assert share.mean == pytest.approx(0.5)
        assert 0.0 <= share.low < 0.5 < share.high <= 1.0
    assert all(share.mean == 1.0 == share.low for share in distance_closed(goal, start, goal).values())
    assert all(share.mean == 0.0 for share in distance_closed(start, start, goal).values())


def test_open_targets_do_not_count_as_contained() -> None:
    start, goal = played([False] * 4, contained=True), played([True] * 4, contained=True)
    run = played([True, True, False, False], contained=True)
    runs = [[replace(r, contained=r.episode != "e0") for r in records] for records in (run, start, goal)]
    found = distance_closed(*runs)
    assert found["SR contained"].n == 3
    assert found["SR contained"].mean == pytest.approx(1 / 3)
    assert found["SPL"].mean == pytest.approx(1 / 2)


def test_no_way_is_no_number_and_no_common_episode_an_error() -> None:
    start = played([True, False], contained=False)
    found = distance_closed(start, start, start)
    assert all(np.isnan(share.mean) for share in found.values())
    worse = distance_closed(start, played([True, True], contained=False), start)
    assert all(np.isnan(share.mean) for share in worse.values())  # no distance to close
    with pytest.raises(ConfigError, match="no episode in common"):
        distance_closed(start, [replace(r, episode=f"other {r.episode}") for r in start], start)


def test_draws_without_a_way_say_nothing() -> None:
    """Only one episode of four differs between start and goal; the three draws in ten without it have no share.

    In all other draws the run has closed half of the distance, so the interval is that one value. Gains of the run in
    other episodes make the draws without it infinite, and those do not count either.
    """
    goal = [record(0), record(1, success=False), record(2, success=False), record(3, success=False)]
    start = [replace(r, success=False, spl=0.0, success_150=False) for r in goal]
    halfway = [replace(goal[0], spl=0.25), *goal[1:]]
    share = distance_closed(halfway, start, goal)["SPL"]
    assert (share.mean, share.low, share.high) == (0.5, 0.5, 0.5)
    elsewhere = [halfway[0], replace(goal[1], spl=0.25), *goal[2:]]
    share = distance_closed(elsewhere, start, goal)["SPL"]
    assert share.mean == 1.0
    assert share.low == 0.5
    assert 1.0 < share.high < 10.0


@pytest.mark.filterwarnings("error")
def test_no_way_and_no_episodes_give_no_number_and_no_warning() -> None:
    start = played([True, False], contained=False)
    found = distance_closed(start, start, start)
    assert all(np.isnan((share.mean, *share.ci95)).all() for share in found.values())
    assert {name: share.n for name, share in found.items()} == {"SPL": 2, "SR 150": 2, "SR contained": 0}
    better = distance_closed(played([True, True], contained=False), start, start)
    assert all(np.isnan(share.mean) for share in better.values()), "not infinitely far"


@pytest.mark.parametrize("samples", [40, pytest.param(200, marks=pytest.mark.slow)])
def test_intervals_hold_what_they_say(samples: int) -> None:
    """About 95 % of the intervals contain the true share, 0.5."""
    rng, held = np.random.default_rng(0), 0
    for _ in range(samples):
        hard = rng.random(120)
        runs = [played((rng.random(120) < rate * (0.5 + hard)).tolist()) for rate in (0.6, 0.4, 0.8)]
        share = distance_closed(*runs)["SPL"]
        held += share.low <= 0.5 <= share.high
    assert 0.9 * samples <= held < samples


def cells(found: dict[str, list[bool]]) -> list[EpisodeRecord]:
    rows = [(split, one) for split, all_of in found.items() for one in all_of]
    return [record(i, success=one, split=split) for i, (split, one) in enumerate(rows)]


def test_what_carries_over() -> None:
    splits = [f"{c}_category/{s}_scene" for c in ("seen", "unseen") for s in ("seen", "unseen")]
    goal = cells({split: [True] * 40 for split in splits})
    run = cells({split: [True] * n + [False] * (40 - n) for split, n in zip(splits, (40, 30, 30, 20), strict=True)})
    found = carried_over(run, goal)
    for kind in ("category", "scene"):
        assert found[kind].seen.mean == pytest.approx(70 / 80)
        assert found[kind].unseen.mean == pytest.approx(50 / 80)
        assert found[kind].lost.mean == pytest.approx(20 / 80)
        assert 0.05 < found[kind].lost.low < 0.25 < found[kind].lost.high < 0.45
    assert carried_over(cells({"val": [True]}), cells({"val": [True]})) == {}


def test_a_goal_that_never_succeeds_gives_no_share() -> None:
    lost = cells({"seen_category/seen_scene": [False] * 4, "unseen_category/unseen_scene": [False] * 4})
    found = carried_over(lost, lost)
    assert all(np.isnan(share.mean) for one in found.values() for share in (one.seen, one.unseen, one.lost))


def test_tables_and_json_show_it(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    splits = ("seen_category/seen_scene", "unseen_category/unseen_scene")
    folders = []
    for agent, n in (("frontier", 2), ("belief", 4), ("oracle_locations", 6)):
        records = [
            replace(r, split=splits[i % 2], agent=agent)
            for i, r in enumerate(played([True] * n + [False] * (8 - n), contained=True))
        ]
        (tmp_path / agent).mkdir()
        (tmp_path / agent / "episodes.jsonl").write_text(to_lines(records))
        folders.append(str(tmp_path / agent))
    start, run, goal = folders
    assert main(["compare", run, "--against", start, "--closed", start, goal, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["runs"][run]["closed"]["SPL"]["mean"] == pytest.approx(0.5)
    assert told["differences"][0]["first"] == run
    assert main(["compare", run, "--against", start, "--closed", start, goal, "--markdown"]) == 0
    page = capsys.readouterr().out
    lines = [line for line in page.splitlines() if line.startswith("| belief")]
    assert "| 50 [" in lines[0]
    assert "% of the SR of oracle_locations" in page
    assert main(["compare", run, "--against", start, "--closed", start, goal]) == 2
    assert "--markdown or --json" in capsys.readouterr().err


def test_without_a_way_nothing_is_added() -> None:
    run = Run("belief, none", tuple(played([True, False])))
    assert "closed" not in markdown_page([run], [])
