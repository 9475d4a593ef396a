import json
import lzma

import pytest

from tests.evaluation.records import BASE, record
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.kept.record import EpisodeRecord, episode_spl, read_records, to_lines


def test_round_trip(tmp_path):
    records = [record(i, success=i % 2 == 0, spl=1 / 3 if i % 2 == 0 else 0.0) for i in range(5)]
    path = tmp_path / "episodes.jsonl"
    path.write_text(to_lines(records))
    again = read_records(tmp_path)
    assert to_lines(again) == path.read_text()
    assert [r.episode for r in again] == [r.episode for r in records]


def test_packed_records_are_read_where_there_are_no_others(tmp_path):
    (tmp_path / "episodes.jsonl.xz").write_bytes(lzma.compress(to_lines([record(i) for i in range(3)]).encode()))
    assert [r.episode for r in read_records(tmp_path)] == [record(i).episode for i in range(3)]
    (tmp_path / "episodes.jsonl").write_text(to_lines([record(7)]))
    assert len(read_records(tmp_path)) == 1


@pytest.mark.parametrize("damage", [lambda raw: raw[:-9], lambda raw: b"no archive", lambda raw: raw[:40] + raw[41:]])
def test_damaged_packed_records_are_named(tmp_path, damage):
    packed = lzma.compress(to_lines([record(i) for i in range(3)]).encode())
    (tmp_path / "episodes.jsonl.xz").write_bytes(damage(packed))
    with pytest.raises(DataError, match=r"episodes.jsonl.xz: incomplete"):
        read_records(tmp_path)


def test_nothing_in_a_record_depends_on_the_clock():
    assert not [name for name in json.loads(BASE.to_line()) if "second" in name or "time" in name]


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ('{"episode": "e0"}\n', "episodes.jsonl:1: not an episode record"),
        (BASE.to_line() + "\n" + BASE.to_line()[:40] + "\n", "episodes.jsonl:2: not JSON"),
        ("", "empty"),
        ("[1, 2]\n", "episodes.jsonl:1"),
    ],
)
def test_bad_files_are_named_with_their_line(tmp_path, text, where):
    (tmp_path / "episodes.jsonl").write_text(text)
    with pytest.raises(DataError, match=where):
        read_records(tmp_path)


def test_missing_run_says_what_was_expected(tmp_path):
    with pytest.raises(DataError, match=r"expected a run folder of eval\.py"):
        read_records(tmp_path / "nothing")


@pytest.mark.parametrize(
    ("success", "shortest", "walked", "expected"),
    [
        (True, 2.0, 2.0, 1.0),
        (True, 2.0, 4.0, 0.5),
        (True, 2.0, 1.0, 1.0),
        (False, 2.0, 2.0, 0.0),
        (True, 3.0, 4.5, 2 / 3),
    ],
)
def test_spl_of_one_episode(success, shortest, walked, expected):
    assert episode_spl(success, shortest, walked) == pytest.approx(expected)


def test_summary_of_known_records():
    figures = summarise([record(0), record(1), record(2, success=False), record(3, success=False)])
    assert figures["n"] == 4
    assert figures["success_rate"] == 0.5
    assert figures["spl"] == 0.25
    assert figures["success_rate_ci95"][0] < 0.5 < figures["success_rate_ci95"][1]
    assert figures["failure_causes"] == {"never_seen": 2}
    assert figures["retrieval"] == {"recall_10": 0.5, "recall_20": 0.75, "mrr": 1.0}
    json.dumps(figures, allow_nan=False)


def test_summary_without_retrieval_has_no_invented_figures():
    figures = summarise([record(0, recall_10=None, recall_20=None, mrr=None)])
    assert figures["retrieval"] == {"recall_10": None, "recall_20": None, "mrr": None}


def test_a_record_that_contradicts_itself_is_refused():
    with pytest.raises(DataError, match="e7"):
        summarise([record(7, spl=0.9, path_length_m=4.0)])


def test_paired_comparison_uses_common_episodes_only():
    first = [record(i, spl=0.5) for i in range(6)]
    second = [record(i, success=False) for i in range(2, 9)]
    comparison = compare_records(first, second)
    assert (comparison.n, comparison.only_first, comparison.only_second) == (4, 2, 3)
    assert comparison.differences["success_rate"].mean == 1.0
    assert comparison.differences["spl"].mean == pytest.approx(0.5)


def test_comparison_refuses_what_cannot_be_paired():
    with pytest.raises(ConfigError, match="no episode in common"):
        compare_records([record(0)], [record(1)])
    with pytest.raises(ConfigError, match="listed twice"):
        compare_records([record(0), record(0)], [record(0)])


def test_unknown_fields_are_refused():
    data = json.loads(BASE.to_line()) | {"extra": 1}
    with pytest.raises(DataError, match="extra"):
        EpisodeRecord.from_json(data)


WRONG = {
    "success": ["no", 1, None, False],
    "success_75": [0, False],
    "success_300": [False],
    "spl": ["0.5", 1, True, 1.5, -0.5, 0.6, None],
    "soft_spl": [2.0],
    "shortest_path_m": [-2.0],
    "steps": [30.0, True, "30", 31, -1, 2**60],
    "actions": ["7" * 30, "1" * 29, "x" * 30, None, "0" * 29 + "\u0661"],
    "opens": [-1, 31],
    "collisions": [1000],
    "first_seen_step": [-2, 31],
    "failure_cause": ["never_seen", "bad luck", None],
    "habit_level": ["some", ""],
    "seed": ["0", 10**30],
    "recall_10": [1, -0.1, 1.1, "x", False],
    "mrr": [2.0],
    "language_calls": [-1],
    "episode": [5, "\ud800", None, [1]],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_every_field_has_its_type_and_does_not_contradict_the_others(tmp_path, name, value):
    (tmp_path / "episodes.jsonl").write_text(json.dumps(json.loads(BASE.to_line()) | {name: value}) + "\n")
    with pytest.raises(DataError, match=r"episodes\.jsonl:1: ") as caught:
        read_records(tmp_path)
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "line",
    [
        BASE.to_line().replace('"spl":0.5', '"spl":NaN').encode(),
        BASE.to_line().replace('"spl":0.5', '"spl":Infinity').encode(),
        BASE.to_line().replace('"spl":0.5', '"spl":1e999').encode(),
        BASE.to_line().replace('"steps":30', f'"steps":{"3" * 5000}').encode(),
        BASE.to_line().replace('"steps":30', '"steps":' + "[" * 200_000).encode(),
        b"[" * 200_000,
        BASE.to_line().replace("coffee_cup", "caf\u00e9").encode("latin-1"),
        BASE.to_line().encode("utf-16"),
    ],
    ids=["NaN", "infinity", "too large", "5,000 digits", "nested field", "nested", "latin-1", "utf-16"],
)
def test_odd_json_ends_in_one_line(tmp_path, line):
    (tmp_path / "episodes.jsonl").write_bytes(line + b"\n")
    with pytest.raises(DataError, match=r"episodes\.jsonl:\d+: ") as caught:
        read_records(tmp_path)
    assert "\n" not in str(caught.value)


def test_names_with_other_line_breaks_are_read_back(tmp_path):
    odd = record(0, target="a\u2028b\x85c\x0bd\re")
    (tmp_path / "episodes.jsonl").write_bytes(to_lines([odd]).encode())
    assert read_records(tmp_path) == [odd]


def test_an_episode_twice_is_refused(tmp_path):
    (tmp_path / "episodes.jsonl").write_text(to_lines([record(0), record(1), record(0)]))
    with pytest.raises(DataError, match="jsonl:3: episode e0 is listed twice"):
        read_records(tmp_path)


def test_a_record_is_what_is_kept_of_it():
    made = record(0, success=False, soft_spl=1 / 3, shortest_path_m=2 / 3)
    assert made.soft_spl == 0.333333
    assert EpisodeRecord.from_json(json.loads(made.to_line())) == made
