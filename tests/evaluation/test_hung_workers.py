"""Workers that stop answering or die: real processes stop or kill themselves, once, always, or in mid-message."""

import math
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from models.agents.random import RandomAgent
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.playing.crew import WorkerError, WorkerPool
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.task.sets import load_episodes

ROOT = Path(__file__).parents[2]
EPISODES = load_episodes("mini")[:4]
pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no signals that stop a process")


class Stops(RandomAgent):
    """Stops or kills its process in one episode, as long as fewer processes than ``times`` have done so."""

    def __init__(self, folder: Path, target: str, times: int, number: int = signal.SIGSTOP) -> None:
        super().__init__(seed=4, done_probability=0.05)
        self._folder, self._target, self._times, self._number = folder, target, times, number

    def reset(self, infos, slots=None):
        super().reset(infos, slots)
        if any(info["target"] == self._target for info in infos) and len(list(self._folder.iterdir())) < self._times:
            (self._folder / str(os.getpid())).touch()
            os.kill(os.getpid(), self._number)


class StopsInMessage(RandomAgent):
    """Stops once, leaving half a message in the pipe."""

    def __init__(self, folder: Path) -> None:
        super().__init__(seed=4, done_probability=0.05)
        self._folder = folder

    def reset(self, infos, slots=None):
        super().reset(infos, slots)
        if not any(self._folder.iterdir()):
            (self._folder / str(os.getpid())).touch()
            frame = sys._getframe()
            while "sender" not in frame.f_locals:
                frame = frame.f_back
            os.write(frame.f_locals["sender"].fileno(), b"\x10\x00\x00\x00half")  # announces 256 MB that never come
            os.kill(os.getpid(), signal.SIGSTOP)


def spec(agent, **options) -> RunSpec:
    env = partial(UcONEnv, EPISODES[:1], habit_level="none", observe="symbolic")
    return RunSpec(agent, env, "none", **options)


def lines(played) -> str:
    return to_lines(one.record for one in played)


@pytest.fixture(scope="module")
def alone() -> str:
    return lines(evaluate(spec(partial(RandomAgent, seed=4, done_probability=0.05)), EPISODES, workers=0))


@pytest.fixture
def impatient(monkeypatch):
    """A limit of one second for a stopped process, and no limit for one that is only slow on a busy machine."""

    def limit(crew: WorkerPool, worker) -> float:
        stat = Path(f"/proc/{worker.process.pid}/stat")
        return 1.0 if stat.is_file() and stat.read_text().rpartition(")")[2].split()[0] in "Tt" else math.inf

    monkeypatch.setattr(WorkerPool, "_limit_s", limit)


def target(number: int) -> str:
    return EPISODES[number].target_category


@pytest.mark.parametrize(("batch", "workers"), [(1, 2), (2, 1)])
def test_a_worker_that_stops_once_is_replaced_and_changes_no_record(impatient, alone, tmp_path, capfd, batch, workers):
    agent = partial(Stops, tmp_path, target(3), 1)
    played = evaluate(spec(agent, batch=batch), EPISODES, workers=workers)
    assert lines(played) == alone
    (stopped,) = (int(path.name) for path in tmp_path.iterdir())
    assert not is_running(stopped)
    told = capfd.readouterr().err
    assert told.count("warning: ucon-eval-") == 1
    assert EPISODES[3].id in told
    assert "worker_timeout_s" in told


@pytest.mark.parametrize(("batch", "workers"), [(1, 2), pytest.param(2, 1, marks=pytest.mark.slow)])
def test_a_worker_that_is_killed_once_is_replaced_and_changes_no_record(alone, tmp_path, capfd, batch, workers):
    agent = partial(Stops, tmp_path, target(3), 1, signal.SIGKILL)
    assert lines(evaluate(spec(agent, batch=batch), EPISODES, workers=workers)) == alone
    told = capfd.readouterr().err
    assert told.count("warning: ucon-eval-") == told.count("\n") == 1
    assert "died with exit code -9" in told
    assert EPISODES[3].id in told


def test_an_episode_that_kills_every_worker_ends_the_run_and_what_is_finished_is_kept(tmp_path):
    kept = []
    agent = partial(Stops, tmp_path, target(1), 9, signal.SIGKILL)
    with pytest.raises(WorkerError, match=r"died with exit code -9 .*: 3 workers began .*") as caught:
        evaluate(spec(agent), EPISODES[:2], workers=2, on_played=kept.append)
    assert f"began {EPISODES[1].id}; finished episodes are kept" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert {one.index for one in kept} <= {0}
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.slow
def test_half_a_message_holds_up_nobody(impatient, alone, tmp_path):
    played = evaluate(spec(partial(StopsInMessage, tmp_path)), EPISODES, workers=2)
    assert lines(played) == alone


def test_an_episode_that_stops_every_worker_ends_the_run_and_what_is_finished_is_kept(impatient, tmp_path):
    kept = []
    agent = partial(Stops, tmp_path, target(1), 9)
    with pytest.raises(EpisodeError, match=r"not finished within .* s by any of 3 workers") as caught:
        evaluate(spec(agent), EPISODES[:2], workers=2, on_played=kept.append)
    assert str(caught.value).startswith(f"{EPISODES[1].id}: ")
    assert "\n" not in str(caught.value)
    assert {one.index for one in kept} <= {0}
    assert len(list(tmp_path.iterdir())) == 3
    assert not any(is_running(int(path.name)) for path in tmp_path.iterdir())


@pytest.mark.slow
def test_the_limit_itself(alone, tmp_path):
    played = evaluate(spec(partial(Stops, tmp_path, target(3), 1)), EPISODES, workers=2, worker_timeout_s=60)
    assert lines(played) == alone


def test_environments_that_take_turns_have_the_limit_each():
    worker = SimpleNamespace(left=[(number, None) for number in range(3)])
    assert WorkerPool(spec(RandomAgent), 10.0)._limit_s(worker) == 10.0
    assert WorkerPool(spec(RandomAgent, batch=2), 10.0)._limit_s(worker) == 20.0
    assert WorkerPool(spec(RandomAgent, batch=8), 10.0)._limit_s(worker) == 30.0
    assert WorkerPool(spec(RandomAgent), 10.0)._limit_s(SimpleNamespace(left=[])) == 10.0


def test_ctrl_c_ends_a_run_with_a_stopped_worker(tmp_path):
    program = (
        "import sys\nfrom functools import partial\nfrom pathlib import Path\n"
        "from tests.evaluation.test_hung_workers import *\n"
        f"evaluate(spec(partial(Stops, Path({str(tmp_path)!r}), target(0), 9)), EPISODES, workers=1)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=ROOT,
        stderr=subprocess.DEVNULL,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )
    try:
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline and not any(tmp_path.iterdir()):
            time.sleep(0.1)
        (stopped,) = (int(path.name) for path in tmp_path.iterdir())
        process.send_signal(signal.SIGINT)
        assert process.wait(30) != 0
        assert not is_running(stopped)
    finally:
        process.kill()


@pytest.mark.parametrize("limit", [0, -1, "long", True, float("nan"), float("inf")])
def test_a_limit_is_a_number_of_seconds(limit):
    with pytest.raises(ConfigError, match=r"worker_timeout_s=.*: expected seconds above 0, or null"):
        evaluate(spec(RandomAgent), EPISODES, workers=0, worker_timeout_s=limit)


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
