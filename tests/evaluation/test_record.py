import json
import lzma

import pytest

from tests.evaluation.records import BASE, record
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.compare import compare_records
from ucon.evaluation.metrics import summarise
from ucon.evaluation.record import EpisodeRecord, episode_spl, read_records, to_lines


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
    with pytest.raises(DataError, match=r"episodes.jsonl.xz: not whole"):
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
    with pytest.raises(ConfigError, match="there twice"):
        compare_records([record(0), record(0)], [record(0)])


def test_unknown_fields_are_refused():
    data = json.loads(BASE.to_line()) | {"extra": 1}
    with pytest.raises(DataError, match="extra"):
        EpisodeRecord.from_json(data)
