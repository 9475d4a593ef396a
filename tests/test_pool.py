"""Pools with stopped processes: nothing waits forever, and no process is left behind."""

import os
import signal
import time

import pytest

from ucon.core.errors import UconError
from ucon.core.pool import Pool

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no signals that stop a process")


def double(number):
    return 2 * number


def own_id(_):
    return os.getpid()


def stops(_):
    os.kill(os.getpid(), signal.SIGSTOP)


def times_out(_):
    raise TimeoutError("of its own")


def is_running(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_results_come_in_order_and_the_processes_end():
    with Pool(2) as pool:
        assert list(pool.map(double, range(30))) == [2 * number for number in range(30)]
        pids = set(pool.map(own_id, range(8)))
        with pytest.raises(TimeoutError, match="of its own"):
            pool.result(pool.submit(times_out, 0))
    assert not any(map(is_running, pids))


def test_a_stopped_process_is_ended_and_told():
    with Pool(1) as pool:
        pid = pool.result(pool.submit(own_id, 0))
        pool._patience_s = 1.0
        with pytest.raises(UconError, match="a worker process has not answered for 1 s") as caught:
            pool.result(pool.submit(stops, 0))
    assert "\n" not in str(caught.value)
    assert not is_running(pid)


def test_leaving_does_not_wait_for_a_stopped_process():
    with pytest.raises(KeyboardInterrupt), Pool(1) as pool:  # noqa: PT012 (the exit from the pool is tested)
        pid = pool.result(pool.submit(own_id, 0))
        pool.submit(stops, 0)
        time.sleep(0.5)
        raise KeyboardInterrupt
    assert not is_running(pid)
