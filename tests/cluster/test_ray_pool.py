"""Labels and lives made on two raylets equal those made locally; a lost machine changes nothing."""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace

import pytest

pytest.importorskip("ray")

from tests.cluster.raylets import ROOT, two_raylets
from tests.learning.tiny_search import search_of
from ucon.cluster.luggage import Luggage
from ucon.cluster.runner import RayRunner
from ucon.core.errors import ConfigError, DataError
from ucon.core.pool import PATIENCE_S, Needs, pools_from
from ucon.evaluation.playing.crew import WorkerError
from ucon.habits.book import contexts_book
from ucon.learning.decisions import store
from ucon.learning.foresight.labels import Beyond
from ucon.lives.making.make_sets import make_lives
from ucon.lives.making.plans import train_order
from ucon.sim.cache import load_house

HOME = "procedural:house:7"


@pytest.fixture(scope="module")
def cluster():
    with two_raylets() as made:
        yield RayRunner(made.address)


@pytest.fixture
def pool(cluster):
    with cluster.pool(1, patience_s=PATIENCE_S) as made:
        yield made


def root_of(number):
    time.sleep(0.05)
    if number < 0:
        raise DataError(f"{number}: below zero")
    return number**0.5, os.getpid()


def failing(number):
    raise RuntimeError("it is broken")


def test_results_come_in_order_from_several_processes(pool):
    found = list(pool.map(root_of, range(20)))
    assert [root for root, _ in found] == [number**0.5 for number in range(20)]
    assert len({process for _, process in found}) == 2
    assert os.getpid() not in {process for _, process in found}


def test_errors_are_told(pool):
    with pytest.raises(DataError, match=r"^-1: below zero$"):
        list(pool.map(root_of, [1, -1]))
    with pytest.raises(WorkerError, match="it is broken"):
        list(pool.map(failing, [1]))


@pytest.mark.slow
def test_labels_are_those_made_here(cluster, tmp_path, monkeypatch):
    found = []
    for name, make in (("here", None), ("there", cluster.pool)):
        monkeypatch.setenv("UCON_CACHE", str(tmp_path / name))
        given = Beyond(), "mini", 16, search_of("foresight"), ("none", "retrieval"), 0, 2
        if make is None:
            store.kept_decisions(*given)
        else:
            with pools_from(make):
                store.kept_decisions(*given)
        files = sorted((tmp_path / name / "foresight").rglob("*.safetensors"))
        found.append([(file.name, file.read_bytes()) for file in files])
    assert len(found[0]) == 2
    assert found[0] == found[1]


@pytest.mark.slow
def test_lives_are_those_made_here_although_a_raylet_is_killed(capfd):
    order = replace(train_order(2, contexts_book(), days=1), changes=False)
    orders = [replace(order, id=f"life {k}", seed=order.seed + k) for k in range(5)]
    with two_raylets() as made, pools_from(RayRunner(made.address).pool):

        def kill(done):
            if done == 1:
                made.wait_until_full()
                made.kill_second()

        found = make_lives(orders, workers=2, progress=kill)
    assert [life.hash for life in found] == [life.hash for life in make_lives(orders, workers=1)]
    assert "warning: worker " in capfd.readouterr().err


def test_homes_and_sets_travel_to_a_machine_without_pybullet(tmp_path):
    """A process with an empty cache that cannot import PyBullet unpacks the luggage and finds both."""
    luggage = Luggage.packed([HOME], ["val"])
    (tmp_path / "luggage").mkdir()
    for name, data in luggage.pack.items():
        (tmp_path / "luggage" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "luggage" / name).write_bytes(data)
    code = """
import sys, json
from pathlib import Path
sys.modules["pybullet"] = None
from ucon.cluster.luggage import Luggage
told = json.loads(sys.argv[1])
folder = Path(sys.argv[2])
pack = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
Luggage(told["code"], told["versions"], ".", pack).unpack()
from ucon.sim.cache import load_house
from ucon.task.sets import episode_sets
assert Path(episode_sets()["val"]).parent.name == "episodes"
print(load_house(sys.argv[3]).spec.hash)
"""
    told = json.dumps({"code": luggage.code, "versions": dict(luggage.versions)})
    env = os.environ | {"UCON_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", code, told, str(tmp_path / "luggage"), HOME]
    result = subprocess.run(words, capture_output=True, text=True, env=env, cwd=tmp_path)
    assert result.stdout.strip() == load_house(HOME).spec.hash, result.stderr


def test_a_machine_with_other_code_is_refused(cluster):
    luggage = Luggage.packed()
    with pytest.raises(ConfigError, match=r"its ucon .* differs from that of this command"):
        replace(luggage, code="0" * 64).unpack()
    with pytest.raises(ConfigError, match=r"numpy .* instead of 0\.1; records can depend on it"):
        replace(luggage, versions={**luggage.versions, "numpy": "0.1"}).unpack()


@pytest.mark.parametrize("address", ["127.0.0.1:9", "ray://127.0.0.1:9", "nowhere"])
def test_an_address_without_a_cluster_is_one_line(address, tmp_path):
    words = ["eval.py", "agent=random", "limit=1", "pictures=0", "runner=ray", f"runner.address={address}"]
    env = os.environ | {"RAY_gcs_rpc_server_connect_timeout_s": "1"}
    result = subprocess.run(
        [sys.executable, *words, f"out={tmp_path / 'run'}", "progress=false"],
        capture_output=True, text=True, cwd=ROOT, env=env,
    )  # fmt: skip
    assert result.returncode != 0
    said = result.stderr.strip().splitlines()
    assert len(said) == 1, result.stderr
    assert "address" in said[0]


def test_needs_are_packed():
    assert {name.split("/")[0] for name in Luggage.packed(Needs((HOME,), ("mini",)).homes, ("mini",)).pack} == {
        "homes",
        "episodes",
    }
