"""Bars are drawn where they belong."""

from __future__ import annotations

from itertools import pairwise

import pytest

pytest.importorskip("matplotlib", reason="pictures are an extra (pip install 'ucon-nav[plots]')")

from ucon.evaluation.figures.plotting import grouped_bars, new_figure


@pytest.mark.parametrize("series", [1, 2])
def test_groups_stand_around_their_name_and_bars_beside_each_other(series: int) -> None:
    axes = new_figure(4, 3, title="heights").subplots()
    rows = [[1.0 + k, 5.0 + k] for k in range(series)]
    grouped_bars(axes, rows, ("low", "high"), str)
    for group in range(2):
        bars = [container[group] for container in axes.containers]
        assert [bar.get_height() for bar in bars] == [row[group] for row in rows]
        middles = [bar.get_x() + bar.get_width() / 2 for bar in bars]
        assert sum(middles) / series == pytest.approx(group)
        ends = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in bars]
        assert all(left[1] <= right[0] for left, right in pairwise(ends))
        assert group - 0.5 < ends[0][0]
        assert ends[-1][1] < group + 0.5
