import json
from dataclasses import replace
from itertools import chain

import pytest

from tests.evaluation.records import record
from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.evaluation.figures.markdown import Run, markdown_page
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.kept.record import to_lines
from ucon.scenes import home_spec


def rows(page, heading):
    """The cells of the table that starts with ``heading``, by first column."""
    table = next(t for t in page.split("\n\n") if t.startswith(f"| {heading} |"))
    return {cells[0]: cells[1:] for line in table.splitlines() for cells in [line.strip("| ").split(" | ")]}


def scenes_of_two_sizes():
    small, large = "Rs_int", "grocery_store_cafe"
    assert home_spec(small).area_m2 < 115 < home_spec(large).area_m2
    return small, large


def two_runs():
    small, large = scenes_of_two_sizes()
    places = [{"scene": small, "split": "seen", "contained": False}, {"scene": large, "split": "unseen"}]
    first = [record(i, **places[i % 2]) for i in range(8)]
    second = [record(i, success=i % 2 == 0, habit_level="none", **places[i % 2]) for i in range(8)]
    return Run("belief, retrieval", tuple(first)), Run("belief, none", tuple(second))


def test_tables_say_what_the_records_say():
    first, second = two_runs()
    page = markdown_page([first, second], [compare_records(first.records, second.records, (first.label, second.label))])
    runs = rows(page, "agent, habits")
    assert runs["belief, retrieval"][0] == "8"
    assert runs["belief, none"][1].startswith("50.0 [")
    assert runs["belief, none"][-1] == "0.0"  # SR of contained targets, all of which are in the home where it failed
    difference = rows(page, "paired difference")["(belief, retrieval) - (belief, none)"]
    assert difference[0] == "8"
    assert difference[1].startswith("+0.250")
    assert difference[2].startswith("+0.500")
    by_group = [t for t in page.split("\n\n") if t.startswith("| SR / SPL |")]
    assert len(by_group) == 2
    for table in by_group:
        cells = rows(table, "SR / SPL")
        assert cells["belief, none"] == ["1.00 / 0.50", "0.00 / 0.00"]
        assert cells["n"] == ["4", "4"]


def test_failures_are_told_by_cause():
    first, second = two_runs()
    mixed = [replace(r, failure_cause="seen_not_reached") if r.episode == "e1" else r for r in second.records]
    causes = rows(markdown_page([first, Run(second.label, tuple(mixed))], []), "% failed by cause")
    assert causes["% failed by cause"] == ["never seen", "seen not reached"]
    assert causes["belief, retrieval"] == ["0.0", "0.0"]
    assert causes["belief, none"] == ["37.5", "12.5"]


def test_two_runs_of_one_name_are_refused():
    first, _ = two_runs()
    with pytest.raises(ConfigError, match="two runs of 'belief, retrieval'"):
        markdown_page([first, first], [])


def test_every_run_is_compared_with_the_one_named(tmp_path, capsys):
    folders = []
    for level in ("none", "full", "gt"):
        folder = tmp_path / level
        folder.mkdir()
        (folder / "episodes.jsonl").write_text(to_lines([record(i, habit_level=level) for i in range(3)]))
        folders.append(str(folder))
    none, full, gt = folders
    assert main(["compare", full, gt, "--against", none, "--json"]) == 0
    pairs = [(c["first"], c["second"]) for c in json.loads(capsys.readouterr().out)]
    assert pairs == [(full, none), (gt, none)]
    assert main(["compare", *folders, "--markdown"]) == 0
    differences = rows(capsys.readouterr().out, "paired difference")
    assert len(differences) == 2 + 3
    assert all(value.startswith("+0.000 [") for value in chain(*(v[1:3] for k, v in differences.items() if "(" in k)))


def test_runs_of_one_agent_and_level_are_told_apart_by_their_folders(tmp_path, capsys):
    folders = [tmp_path / name for name in ("frozen", "tuned", "none")]
    for folder in folders:
        folder.mkdir()
        level = "none" if folder.name == "none" else "retrieval"
        (folder / "episodes.jsonl").write_text(to_lines([record(i, habit_level=level) for i in range(3)]))
    assert main(["compare", *map(str, folders[:2]), "--against", str(folders[2]), "--markdown"]) == 0
    page = capsys.readouterr().out
    assert "| belief, retrieval: frozen |" in page
    assert "| (belief, retrieval: tuned) - (belief, none) |" in page
    assert "| belief, none |" in page


def by_kind():
    """Two runs in scenes, flats and houses; the second fails in flats."""
    homes = ("Rs_int", "procedural:flat:3", "procedural:house:1", "Benevolence_1_int")
    first = [record(i, scene=homes[i % 4]) for i in range(12)]
    second = [record(i, scene=homes[i % 4], success=i % 4 != 1, habit_level="none") for i in range(12)]
    return first, second


def written(tmp_path, **runs):
    for name, records in runs.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "episodes.jsonl").write_text(to_lines(records))
    return [str(tmp_path / name) for name in runs]


def test_kinds_of_homes_are_compared_each_for_itself(tmp_path, capsys):
    first, second = by_kind()
    paths = written(tmp_path, one=first, two=second)
    assert main(["compare", *paths, "--markdown", "--by-kind"]) == 0
    kinds = rows(capsys.readouterr().out, "SPL by kind of home")
    assert list(kinds) == ["SPL by kind of home", "---", "generated flats", "generated houses", "scenes"]
    assert [cells[0] for cells in list(kinds.values())[2:]] == ["3", "3", "6"]
    assert kinds["generated flats"][1].startswith("+0.500")
    assert kinds["scenes"][1].startswith("+0.000")
    assert main(["compare", *paths, "--json", "--by-kind"]) == 0
    told = json.loads(capsys.readouterr().out)["kinds"]
    assert told["generated flats"][0]["differences"]["success_rate"]["difference"] == 1.0
    assert main(["compare", *paths, "--by-kind"]) == 0
    assert "generated houses" in capsys.readouterr().out


def test_runs_of_two_sets_are_joined(tmp_path, capsys):
    first, second = by_kind()
    a, b, c, d = written(tmp_path, a=first[:5], b=first[5:], c=second[:5], d=second[5:])
    assert main(["compare", f"{a}+{b}", f"{c}+{d}", "--json"]) == 0
    joined = json.loads(capsys.readouterr().out)[0]
    assert joined["n"] == 12
    assert joined["differences"]["success_rate"]["difference"] == 0.25
    assert main(["compare", f"{a}+{d}", b]) != 0
    assert "join those of one agent and level" in capsys.readouterr().err


def test_budgets_count_a_search_that_ends_in_time():
    records = (record(0, steps=75, spl=0.5), record(1, steps=76, spl=0.25), record(2, success=False))
    budgets = rows(markdown_page([Run("a", records)], []), "SR / SPL within")
    assert budgets["a"] == ["0.333 / 0.167", "0.667 / 0.250", "0.667 / 0.250"]


def test_named_subsets_are_told_where_every_run_has_them():
    named = rows(markdown_page([Run("a", (record(0), record(1, success=False, contained=False)))], []), "subset")
    assert named["subset"] == [f"contained targets: {what}" for what in ("n", "SR % [95 %]", "SPL [95 %]")]
    assert named["a"][0] == "1"
    assert named["a"][1].startswith("100.0 [")
    free = markdown_page([Run("a", (record(0, contained=False),))], [])
    assert "| subset |" not in free


@pytest.mark.slow
def test_when_habits_pay_is_told_within_groups_that_make_up_the_whole(capsys):
    folders = [f"results/learned-habit_policy-{level}" for level in ("retrieval", "none")]
    assert main(["compare", *folders, "--markdown", "--when"]) == 0
    page = capsys.readouterr().out
    groups = rows(page, "SPL within")
    for title in ("variety among households", "common sense", "size of home"):
        assert sum(int(cells[0]) for name, cells in groups.items() if name.startswith(title)) == 1000
    assert sorted(groups) != list(groups)
    against = int(groups["common sense: 0-1 times chance"][0])
    assert rows(page, "subset")["habit_policy, none"][3] == str(against)
    assert main(["compare", *folders, "--json", "--when"]) == 0
    told = json.loads(capsys.readouterr().out)["groups"]
    assert {name: str(pairs[0]["n"]) for name, pairs in told.items()} == {
        name: cells[0] for name, cells in groups.items() if ": " in name
    }
    assert main(["compare", *folders, "--when"]) == 2
    assert "--when is shown only with --markdown or --json" in capsys.readouterr().err
