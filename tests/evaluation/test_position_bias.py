"""Position bias in summaries and tables: how often a model chooses each position in a list."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ucon.core.errors import DataError
from ucon.evaluation.figures.bias_table import bias_line, bias_rows
from ucon.evaluation.kept.decisions import DecisionRecord, language_figures
from ucon.evaluation.kept.finished import check_summary
from ucon.evaluation.kept.position_bias import PositionBias

SIDES = ("front", "left", "behind", "right")


def decision(places: tuple[int, ...], answered: int, options: tuple[str, ...] = SIDES) -> DecisionRecord:
    return DecisionRecord("e0", 0, 0, "view", options, answered, asked=1, answered=answered, places=places)


MADE = [
    decision((0, 3), 1),  # the same option in both orders
    decision((0, 0), 3),
    decision((1, 0), 3),
    decision((0, 1), 0, SIDES[:2]),
    replace(decision((), 0), asked=0),  # the only candidate
]


def test_places_are_counted_by_the_length_of_the_list() -> None:
    bias = PositionBias.of(MADE)
    assert bias is not None
    assert bias.chosen[4] == (6, (4 / 6, 1 / 6, 0.0, 1 / 6))
    assert bias.chosen[2] == (2, (0.5, 0.5))
    assert bias.agreement == 0.5  # the first and last of four decisions
    assert bias.named == {"behind": 0.0, "front": 0.25, "left": 0.25, "right": 0.5}
    assert PositionBias.of(MADE[-1:]) is None
    once = PositionBias.of([decision((2,), 2)])
    assert once is not None
    assert once.agreement is None


def test_many_names_are_not_counted() -> None:
    many = PositionBias.of([decision((0,), 0, tuple(f"thing {k}" for k in range(9)))])
    assert many is not None
    assert many.named == {}


def test_a_summary_keeps_it_and_tables_show_it() -> None:
    figures = {"language": language_figures(MADE, 1)}
    assert PositionBias.in_summary(figures) == PositionBias.of(MADE)
    rows = bias_rows("lgx, none", figures)
    assert [row[:4] for row in rows] == [("lgx, none", "2", "2", "50, 50"), ("lgx, none", "4", "6", "67, 17, 0, 17")]
    assert rows[0][4:] == ("50", "behind 0, front 25, left 25, right 50")
    assert bias_line(figures) == (
        "places in a list of 4 chosen by the model: 67, 17, 0, 17 % of 6; the same in both orders: 50 %; "
        "by name: behind 0, front 25, left 25, right 50 %"
    )


@pytest.mark.parametrize("summary", [{}, {"language": None}, {"language": {"retries": 0}}])
def test_models_that_read_no_list_have_none(summary: dict) -> None:
    assert PositionBias.in_summary(summary) is None
    assert bias_line(summary) == ""


@pytest.mark.parametrize(
    "told",
    [
        [],
        {"chosen": {}},
        {"chosen": {"2": {"choices": 1, "shares": [1.0]}}, "agreement": None, "named": {}},
        {"chosen": {"2": {"choices": -1, "shares": [1.0, 0.0]}}, "agreement": None, "named": {}},
        {"chosen": {"two": {"choices": 1, "shares": [1.0, 0.0]}}, "agreement": None, "named": {}},
        {"chosen": {}, "agreement": 2.0, "named": {}},
        {"chosen": {}, "agreement": None, "named": {"front": "all"}},
    ],
)
def test_another_form_is_refused_in_one_line(told: object) -> None:
    summary = {
        **dict.fromkeys(("n", "success_rate", "spl", "soft_spl", "success_75", "success_150", "success_300"), 0),
        **{"steps": 0, "success_rate_ci95": [0, 0], "spl_ci95": [0, 0], "agent": "a", "habit_level": "none"},
        **{"retrieval": {}, "failure_causes": {}, "hashes": {}},
    }
    check_summary(summary, Path("summary.json"))
    with pytest.raises(DataError, match=r"summary\.json: position_bias is malformed") as caught:
        check_summary({**summary, "language": {"position_bias": told}}, Path("summary.json"))
    assert "\n" not in str(caught.value)


def test_a_stored_line_has_places_only_where_there_are_some() -> None:
    with_places, without = MADE[0], replace(MADE[0], places=())
    assert '"places":[0,3]' in with_places.to_line()
    assert "places" not in without.to_line()
    for one in (with_places, without):
        assert DecisionRecord.from_json(json.loads(one.to_line())) == one
    with pytest.raises(DataError, match="counts below 0"):
        DecisionRecord.from_json(json.loads(with_places.to_line()) | {"places": [-1]})
