"""SPL of random records: its bounds, no effect of their order, and never more for a longer path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.records import record
from ucon.core.rng import stream
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.record import EpisodeRecord, episode_spl

RUNS = 200


def drawn(number: int) -> list[EpisodeRecord]:
    """A random run's records, by its number: 1 to 40 episodes, any share of successes, paths of 0 to 50 m."""
    rng = stream(number, "records")
    share, found = rng.random(), []
    for k in range(int(rng.integers(1, 41))):
        success, shortest, walked = bool(rng.random() < share), *map(float, rng.uniform(0, 50, 2))
        spl = episode_spl(success, shortest, walked)
        made = record(k, success=success, steps=int(rng.integers(30, 301)) if success else 300)
        soft = float(rng.uniform(spl, 1))
        found.append(replace(made, spl=spl, soft_spl=soft, shortest_path_m=shortest, path_length_m=walked))
    return found


@pytest.mark.parametrize("number", range(RUNS))
def test_of_any_run(number: int) -> None:
    records, rng = drawn(number), stream(number, "change")
    figures = summarise(records)
    assert 0 <= figures["spl"] <= figures["success_rate"] <= 1
    assert figures["success_75"] <= figures["success_150"] <= figures["success_rate"]
    shuffled = summarise([records[k] for k in rng.permutation(len(records))])
    for name in ("n", "success_rate", "spl", "soft_spl", "success_75", "success_150"):
        assert shuffled[name] == pytest.approx(figures[name], abs=1e-12), name
    one = int(rng.integers(len(records)))
    longer = records[one].path_length_m + float(rng.uniform(0.01, 20))
    worse = replace(
        records[one],
        path_length_m=longer,
        spl=episode_spl(records[one].success, records[one].shortest_path_m, longer),
    )
    assert summarise([*records[:one], worse, *records[one + 1 :]])["spl"] <= figures["spl"]


def test_one_episode() -> None:
    """SPL is 0 for a failure, 1 up to the shortest path, and falls as the path grows, on a grid of path lengths."""
    ways = np.linspace(0.25, 60, 80)
    for shortest in ways:
        found = [episode_spl(True, float(shortest), float(walked)) for walked in ways]
        assert found == sorted(found, reverse=True)
        assert all((value == 1.0) == (walked <= shortest) for value, walked in zip(found, ways, strict=True))
        assert min(found) > 0
        assert {episode_spl(False, float(shortest), float(walked)) for walked in ways} == {0.0}
