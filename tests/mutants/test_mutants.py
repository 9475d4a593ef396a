"""The mutation testing harness: what it tries, with which tests, and that the tree stays unchanged."""

from __future__ import annotations

import multiprocessing
import subprocess
import textwrap
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

pytest.importorskip("cosmic_ray", reason="mutation testing is an extra of its own (pip install '.[mutants]')")
pytest.importorskip("coverage", reason="mutation testing is an extra of its own (pip install '.[mutants]')")

from cosmic_ray.commands.init import init
from cosmic_ray.work_db import WorkDB, use_db

from tests.mutants.copies import depending, own_cache, refresh
from tests.mutants.places import Mutation, changed_line, mutated, mutations
from tests.mutants.reach import Reach, Recorded
from tests.mutants.recording import moved
from tests.mutants.report import Outcome, killed_share, known, report
from tests.mutants.sample import allotted, sampled
from tests.mutants.trial import attempt

ROOT = Path(__file__).parents[2]


def tree(root: Path, **files: str) -> Path:
    """A small repository; ``models__x`` is ``models/x.py``."""
    for name, text in files.items():
        path = root / f"{name.replace('__', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip())
    return root


def test_mutations_are_cosmic_rays_own(tmp_path: Path) -> None:
    """Occurrences are numbered as cosmic-ray counts them, so it makes exactly the mutation that was drawn."""
    file = "ucon/evaluation/figures/metrics.py"
    with use_db(str(tmp_path / "all.sqlite"), WorkDB.Mode.create) as db:
        init([ROOT / file], db, {})
        theirs = {(m.operator_name, m.occurrence): m.start_pos for item in db.work_items for m in item.mutations}
    ours = mutations(ROOT, file)
    assert 50 < len(ours) < len(theirs)
    lines = (ROOT / file).read_text().splitlines()
    for one in ours:
        line, column = theirs[one.operator, one.occurrence]
        assert (line, column - lines[line - 1].index(one.text)) == (one.line, one.column)
    assert len({one.key for one in ours}) == len(ours)


def test_what_means_nothing_is_left_out(tmp_path: Path) -> None:
    source = """
        from typing import TYPE_CHECKING, TypeAlias

        __all__ = ["f" + "g"]
        Table: TypeAlias = "list[1 + 1]"
        if TYPE_CHECKING:
            WRONG = 1 + 1

        @lru_cache(maxsize=5)
        def f(x: int | None = 7, y: "a | b" = None) -> int | str:
            \"\"\"1 + 1.\"\"\"
            z: int | float = x
            log.warning(f"{x + 1}")
            if z is y:
                raise ValueError(f"{x * 2}")
            return [a for a, b in zip(z, y, strict=True)]

        if __name__ == "__main__":
            f(1)
    """
    tree(tmp_path, models__x=source)
    found = {one.text for one in mutations(tmp_path, "models/x.py")}
    assert found == {'def f(x: int | None = 7, y: "a | b" = None) -> int | str:', "if z is y:"}


def test_the_sample_changes_only_where_code_does(tmp_path: Path) -> None:
    body = "\n".join(f"def f{k}(x):\n    return x + {k} if x > {k} else -x\n" for k in range(40))
    names = ("ucon__task__x", "ucon__retrieval__x", "ucon__evaluation__x", "ucon__perception__x", "ucon__envs__x")
    tree(tmp_path, **dict.fromkeys((*names, "ucon__learning__x", "models__x"), body))
    before = {one.key for one in sampled(tmp_path, 70, 0)}
    assert len(before) == 70
    assert before == {one.key for one in sampled(tmp_path, 70, 0)} != {one.key for one in sampled(tmp_path, 70, 1)}
    (tmp_path / "models/x.py").write_text("# A comment.\n\n" + body.replace("x + 7", "x * 7"))
    after = {one.key for one in sampled(tmp_path, 70, 0)}
    assert len(before & after) >= 68
    for one in sampled(tmp_path, 70, 0):
        compile(mutated((tmp_path / one.file).read_text(), one), one.file, "exec")


def test_parts_are_drawn_by_their_size() -> None:
    assert allotted({"a": 50, "b": 30, "c": 20}, 10) == {"a": 5, "b": 3, "c": 2}
    assert allotted({"a": 1, "b": 1, "c": 1}, 4) in ({"a": 2, "b": 1, "c": 1}, {"a": 1, "b": 2, "c": 1})
    assert sum(allotted({"a": 7, "b": 11, "c": 83}, 150).values()) == 150


KERNELS = """
    from ucon.core.jit import jit

    NEAR = 3
    FAR = 9

    @jit
    def inner(x):
        return x + 1

    @jit
    def outer(x):
        return inner(x) * NEAR

    def called(x, y=5):
        return outer(x) - y

    def other(x):
        return x * FAR

    SIZE = 8

    @lru_cache(SIZE)
    def kept(x):
        return x - 2
"""


@pytest.mark.parametrize(
    ("text", "tests"),
    [
        ("return x + 1", {"tests/t.py::calls"}),
        ("return inner(x) * NEAR", {"tests/t.py::calls"}),
        ("NEAR = 3", {"tests/t.py::calls"}),
        ("FAR = 9", {"tests/t.py::others"}),
        ("def called(x, y=5):", {"tests/t.py::calls"}),
        ("return x * FAR", {"tests/t.py::others"}),
        ("SIZE = 8", {"tests/t.py::keeps"}),
    ],
)
def test_kernels_and_constants_are_reached_by_who_uses_them(text: str, tests: set[str], tmp_path: Path) -> None:
    tree(tmp_path, models__x=KERNELS)
    lines = (tmp_path / "models/x.py").read_text().splitlines()
    ran = {"return outer(x) - y": "calls", "return x * FAR": "others", "return x - 2": "keeps"}
    by_line = {
        ("models/x.py", 1 + k): f"tests/t.py::{ran[one.strip()]}" for k, one in enumerate(lines) if one.strip() in ran
    }
    recorded = Recorded(dict.fromkeys(by_line.values(), 0.1), {line: frozenset({t}) for line, t in by_line.items()})
    mutation = next(one for one in mutations(tmp_path, "models/x.py") if one.text == text)
    assert set(Reach(tmp_path, recorded).tests(mutation, 60.0)) == tests


def test_quick_tests_of_the_own_part_come_first(tmp_path: Path) -> None:
    tree(tmp_path, models__x="def f(x):\n    return x + 1\n")
    seconds = {"tests/task/t.py::a": 0.1, "tests/models/t.py::slow": 50.0, "tests/models/t.py::quick": 1.0}
    recorded = Recorded(seconds, {("models/x.py", 2): frozenset(seconds)})
    mutation = mutations(tmp_path, "models/x.py")[0]
    reach = Reach(tmp_path, recorded)
    assert reach.tests(mutation, 60.0) == ["tests/models/t.py::quick", "tests/models/t.py::slow", "tests/task/t.py::a"]
    assert reach.tests(mutation, 10.0) == ["tests/models/t.py::quick", "tests/task/t.py::a"]


def test_programs_are_met_by_tests_that_name_them(tmp_path: Path) -> None:
    tree(
        tmp_path,
        models__far_worker="X = 3\n",
        tests__test_far="",
        tests__test_other="",
        tests__test_y="models.far_worker",
    )
    names = ("tests/test_far.py::a", "tests/test_other.py::b", "tests/test_y.py::c")
    reach = Reach(tmp_path, Recorded(dict.fromkeys(names, 0.1), {}))
    assert set(reach.tests(mutations(tmp_path, "models/far_worker.py")[0], 60.0)) == {names[0], names[2]}


def test_records_move_with_their_lines() -> None:
    before, after = "a\nb\nc\nd\n", "new\na\nB1\nB2\nc\n"
    assert moved(before, after) == {1: [2], 2: [3, 4], 3: [5], 4: []}


def test_kernels_that_a_file_has_no_part_in_are_kept(tmp_path: Path) -> None:
    tree(
        tmp_path,
        ucon__a="X = 1\n",
        ucon__b="from ucon.a import X\n",
        ucon__c="from ucon import b\n",
        models__d="from ucon.c import y\n",
        models__e="import numpy\n",
    )
    assert depending(tmp_path, "ucon/b.py") == {"ucon/b.py", "ucon/c.py", "models/d.py"}


def test_a_mutant_is_tried_in_a_copy_and_leaves_nothing(tmp_path: Path) -> None:
    root = tree(
        tmp_path / "root",
        models__x="def f(x):\n    return x > 1\n",
        tests__test_x="""
            from models.x import f

            def test_far():
                assert f(5)

            def test_near():
                assert not f(1)
        """,
    )
    subprocess.run(["git", "init", "-q"], cwd=root, check=True)
    session, tests = tmp_path / "session", [f"tests/test_x.py::test_{name}" for name in ("far", "near")]
    refresh(root, session / "copy-0")
    (root / "tests/gone.py").write_text("")
    refresh(root, session / "copy-0")
    (root / "tests/gone.py").unlink()
    refresh(root, session / "copy-0")
    assert not (session / "copy-0/tests/gone.py").exists()
    ways = {one.operator: one for one in mutations(root, "models/x.py")}
    mutant = ways["core/ReplaceComparisonOperator_Gt_GtE"]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as processes:
        by_both = processes.submit(attempt, session, 0, mutant, tests, 1.0).result()
        by_one = processes.submit(attempt, session, 0, mutant, tests[:1], 1.0).result()
        by_none = processes.submit(attempt, session, 0, mutant, [], 0.0).result()
    assert (by_both.killed, by_both.by) == (True, "tests/test_x.py::test_near")
    assert not by_one.killed
    assert (by_none.killed, by_none.by) == (False, "no test reaches it")
    for place in (root, session / "copy-0"):
        assert (place / "models/x.py").read_text() == "def f(x):\n    return x > 1\n"


def test_what_a_mutant_writes_into_its_cache_nobody_reads(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "good").write_text("good")
    with own_cache(kept, tmp_path / "own") as own:
        (own / "new").write_text("wrong")
        (own / "good.part").write_text("wrong")
        (own / "good.part").replace(own / "good")
    assert [path.name for path in kept.iterdir()] == ["good"]
    assert (kept / "good").read_text() == "good"


def outcome(mutation: Mutation, killed: bool) -> Outcome:
    return Outcome(mutation, "after", killed, "some test")


def test_those_that_live_are_listed_and_those_listed_count_as_alive(tmp_path: Path) -> None:
    tree(tmp_path, models__x="def f(x):\n    return x + 1\n")
    first, *others = mutations(tmp_path, "models/x.py")
    outcomes = [outcome(first, False), *(outcome(one, True) for one in others[:8]), outcome(others[8], False)]
    assert killed_share(outcomes) == 0.8
    told = report(outcomes, {(first.file, "f", first.text, "after"): "no matter"})
    assert "equivalent: no matter" in told
    told = report(outcomes, {})
    assert told.count("to look at") == 3, "the head of the table, and two mutants"


def test_mutants_listed_as_equivalent_are_still_there() -> None:
    """A reason is given for a certain line; when the line changes, its mutant must be judged again."""
    by_file: dict[str, set[tuple[str, str, str]]] = {}
    for (file, function, before, after), why in known().items():
        assert len(why) > 20
        by_file.setdefault(file, set()).add((function, before, after))
    for file, wanted in by_file.items():
        source, found = (ROOT / file).read_text(), set()
        for one in mutations(ROOT, file):
            if any((one.function, one.text) == (function, before) for function, before, _ in wanted):
                found.add((one.function, one.text, changed_line(source, one)))
        assert wanted <= found, file
