"""Simulated schedules: properties that hold for all of them, and the cost of trouble."""

import json

import pytest

from ucon.__main__ import main
from ucon.cluster.roles import piece_size
from ucon.cluster.schedule import Trouble, simulate
from ucon.core.errors import ConfigError

EASY = Trouble(lost_per_hour=0, slow_share=0, start_s=0)
SECONDS = [1.0 + k % 3 for k in range(900)]


def test_without_trouble_the_work_is_divided():
    one, many = simulate(SECONDS, 1, EASY), simulate(SECONDS, 16, EASY)
    assert one.wall_s == sum(SECONDS)
    assert one.efficiency == 1
    assert sum(SECONDS) / 16 <= many.wall_s < sum(SECONDS) / 16 * 1.05
    assert (many.lost, many.again_s) == (0, 0)


def test_more_workers_than_jobs_end_with_the_longest():
    assert simulate([3.0, 1.0], 64, EASY).wall_s == 3.0


def test_trouble_costs_time_and_no_job():
    found = simulate(SECONDS, 16, Trouble(lost_per_hour=30, slow_share=0.25))
    assert found.lost > 3
    assert found.again_s > 0
    assert found.work_s == sum(SECONDS)
    assert found.efficiency < 0.8
    assert found == simulate(SECONDS, 16, Trouble(lost_per_hour=30, slow_share=0.25))


def test_the_last_worker_that_is_lost_is_waited_for():
    """One worker and one job: the job is restarted after each loss and finished in the end."""
    trouble = Trouble(lost_per_hour=5, slow_share=0, start_s=1, found_s=1)
    found = max((simulate([1200.0], 1, trouble, seed=seed) for seed in range(9)), key=lambda one: one.lost)
    assert found.lost > 1
    assert found.wall_s > 1200 + found.again_s


def test_pieces_become_fewer():
    left, sizes = 1000, []
    while left:
        sizes.append(piece_size(left, 2, 10))
        left -= sizes[-1]
    assert sizes[0] == 25
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] <= 2


@pytest.mark.parametrize("number", [-1, 61, float("nan"), "1"])
def test_bad_rates_are_refused(number):
    with pytest.raises(ConfigError, match=r"lost_per_hour=.*: expected a number"):
        Trouble(lost_per_hour=number)


def test_a_finished_run_is_reckoned(tmp_path, capsys):
    from ucon.programs.composing import eval_config
    from ucon.programs.evaluating import Evaluation

    config = eval_config("agent=random", "habit_level=none", "limit=3", "pictures=0", "workers=0", "progress=false")
    Evaluation(config | {"out": str(tmp_path)}, tmp_path).play()
    assert (
        main(["bench", "--cluster", str(tmp_path), "--workers", "1", "4", "--lost", "0", "--slow", "0", "--json"]) == 0
    )
    one, four = json.loads(capsys.readouterr().out)
    assert one["wall_s"] > four["wall_s"]
    assert main(["bench", "--cluster", str(tmp_path), "--runs", "100"]) == 0
    assert "300 episodes" in capsys.readouterr().out
