"""Every shipped episode set: verified, solved by the oracle, and made within the promised time."""

from __future__ import annotations

import itertools
import resource
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from models.agents.oracle import OracleAgent
from ucon.configuration.wiring import official_habits
from ucon.core.errors import EpisodeError
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.habits import book
from ucon.habits.splits import PARTS_USED, entry_parts
from ucon.task import sets
from ucon.task.making.make_sets import make_episodes, verify_episode
from ucon.task.making.set_plans import HELD_OUT, N_OFFICIAL, OFFICIAL, OFFICIAL_HELD_OUT, set_cells, set_orders
from ucon.task.robot.rig import RobotRig
from ucon.task.rules import PAPER, RELEASED_CODE, RULES, task_rules
from ucon.task.sets import episode_sets, load_episodes, set_name

RELEASE = Path(__file__).resolve().parents[2] / "../shared/official_release/task"
SIZES = {"mini": 25, "val": 200, "test": 250, "test_large": 500, "train": 2000}
"""Episodes in each cell."""
FAST = ("mini", "mini.released_code", "mini.real_robot")
SETS = [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in episode_sets()]


def of_the_book(name: str) -> bool:
    return load_episodes(name)[0].habits == "book"


@pytest.mark.parametrize("task", RULES)
def test_the_mini_set_is_installed_under_every_rule_set(task: str) -> None:
    assert set_name("mini", task) in episode_sets()
    assert {e.task for e in load_episodes("mini", task)} == {task}


def test_the_rule_sets_search_the_same_arrangements() -> None:
    paper, released = load_episodes("mini", PAPER.name), load_episodes("mini", RELEASED_CODE.name)
    assert [e.scene for e in paper] == [e.scene for e in released]
    assert [e.split for e in paper] == [e.split for e in released]
    assert not {e.id for e in paper} & {e.id for e in released}
    alike = sum(a.arrangement.objects == b.arrangement.objects for a, b in zip(paper, released, strict=True))
    assert alike >= 0.9 * len(paper)


def test_a_set_that_is_missing_under_a_rule_set_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = {name: path for name, path in episode_sets().items() if name in FAST}
    monkeypatch.setattr(sets, "episode_sets", lambda: installed | {"mine": installed["mini"]})
    assert load_episodes("mine", PAPER.name) == load_episodes("mini")
    with pytest.raises(EpisodeError, match=r"'mine': not made under task=released_code.*choose episodes=mini,"):
        load_episodes("mine", RELEASED_CODE.name)
    by_path = load_episodes(installed["mini"], RELEASED_CODE.name)
    assert {e.task for e in by_path} == {PAPER.name}, "a file is played as it is"


@pytest.mark.parametrize("name", SETS)
def test_every_stored_solution_succeeds(name: str) -> None:
    wrong = {e.id: found for e in load_episodes(name) if (found := verify_episode(e))}
    assert not wrong


@pytest.mark.parametrize("name", SETS)
def test_the_oracle_scores_full_marks(name: str) -> None:
    if not of_the_book(name):
        pytest.skip("made with habits that are given by path")
    episodes = load_episodes(name)
    rules = task_rules(episodes[0].task)
    rig = RobotRig.exact() if rules.continuous else None
    options = {"habit_level": "none", "observe": "symbolic", "privileged": True, "rig": rig}
    env = partial(UcONEnv, episodes[:1], task=rules.name, **options)
    records = [p.record for p in evaluate(RunSpec(OracleAgent, env, "none"), episodes, workers=0)]
    assert all(r.success for r in records)
    least = 0.8 if rules.continuous else 0.99  # a robot's shortest path need not keep to its six headings
    assert sum(r.spl for r in records) / len(records) >= least


@pytest.mark.parametrize("name", episode_sets())
def test_sets_are_what_they_say(name: str) -> None:
    episodes = load_episodes(name)
    assert len({e.id for e in episodes}) == len(episodes)
    assert all(e.shortest_path_m > 0 and len(e.solution) <= 300 for e in episodes)
    alike = [(e, [o.category for o in e.arrangement.objects]) for e in episodes]
    assert all(names.count(e.target_category) == 1 for e, names in alike)
    base = name.split(".")[0]
    stated = episodes[0].context is not None
    assert name == set_name(base, episodes[0].task, context=stated)
    assert len({e.task for e in episodes}) == 1
    if base in SIZES:
        cells = {cell.label: cell for cell in set_cells(base)}
        assert Counter(e.split for e in episodes) == dict.fromkeys(cells, SIZES[base])
        assert all(e.scene in cells[e.split].scenes for e in episodes)
        parts = entry_parts(book())
        for episode in episodes:
            assert {parts[i] for i in episode.entries} <= PARTS_USED[cells[episode.split].part], episode.id


@pytest.mark.parametrize("task", RULES)
def test_sampling_again_gives_the_same_episodes(task: str) -> None:
    """Sampling the first orders of the mini set again gives the episodes in the file."""
    stored = {e.id: e for e in load_episodes("mini", task)}
    orders = list(itertools.islice(set_orders("mini", book(), task), 2))
    made = make_episodes(orders, task=task, workers=1)
    assert made == [stored[episode.id] for episode in made]


@pytest.mark.slow
def test_a_thousand_episodes_in_five_minutes() -> None:
    """On two cores; measured on a tenth of them, in CPU time, which other programs affect little."""
    orders = list(itertools.islice(set_orders("test", book()), 0, 1000, 10))
    before = cpu_seconds_of_children()
    assert len(make_episodes(orders, workers=2)) == 100
    assert cpu_seconds_of_children() - before < 2 * 300 / 10


def cpu_seconds_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


@pytest.mark.skipif(not RELEASE.is_dir(), reason="the official release's files are not at hand")
def test_official_targets_of_held_out_episodes_are_never_learned_from():
    dataset = official_habits(str(RELEASE))
    parts = entry_parts(dataset)
    kept = {(e.scene, e.category) for e in dataset.entries if parts[e.id] == "test"}
    orders = list(set_orders(OFFICIAL, dataset))
    assert len(orders) == N_OFFICIAL
    for order in orders:
        assert {(order.scene, name) in kept for name in order.targets} == {order.split == HELD_OUT}, order
    assert {o.scene for o in orders} == set(dataset.scenes)
    assert sum(o.split == HELD_OUT for o in orders) >= N_OFFICIAL // 4
    orders = list(set_orders(OFFICIAL_HELD_OUT, dataset))
    assert len({order.id for order in orders}) == 1000
    assert all((o.scene, name) in kept and len(o.targets) >= 3 for o in orders for name in o.targets)


@pytest.mark.parametrize(("name", "homes", "episodes"), [("test", 20, 1000), ("test_large", 40, 2000)])
def test_test_sets_have_the_sizes_that_results_name(name: str, homes: int, episodes: int) -> None:
    orders = list(set_orders(name, book()))
    assert len(orders) == episodes
    assert len({order.scene for order in orders if order.scene.startswith("procedural:")}) == homes
